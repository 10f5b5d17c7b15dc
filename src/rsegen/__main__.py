"""python -m rsegen."""

import sys

from rsegen.cli import main

sys.exit(main())
