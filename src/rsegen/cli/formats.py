"""Formats of other programs in the help, and the list that explains them."""

from __future__ import annotations

from collections.abc import Iterator

from rsegen.cli.parser import HelpRow, Parser
from rsegen.params.registry import offered_names


def add_format_rows(command: Parser, flag: str = "--formats") -> None:
    """Add the names of formats and of their options to the help."""

    def rows() -> Iterator[HelpRow]:
        yield HelpRow(", ".join(offered_names("rsegen.exporters.formats", "rsegen.formats")), "")

    command.add_rows(f"formats for {flag} (rsegen export --list explains them and their options)", rows)


def listed() -> Iterator[str]:
    """Yield the lines on every format and its options."""
    from rsegen.exporters.formats import FORMATS
    from rsegen.params.extras import MAT
    from rsegen.params.registry import summary
    from rsegen.params.sorts import parameters

    for name, cls in FORMATS.items():
        extra = f"rsegen[{cls.extra.name if cls.extra else MAT.name}]"
        needs = f" Needs {extra}." if cls.extra else f" {cls.mat_file} needs {extra}." if cls.mat_file else ""
        source = FORMATS.source(name)
        yield f"{name}\n    {summary(cls)}{needs}" + (f" From {source}." if source else "")
        for option, parameter in parameters(cls).items():
            yield f"    {f'{option}=':<15} {parameter.help}: {parameter.describe()}"
        yield ""
