"""Write what it takes to build a map in wood: the cuts, the timber to buy, and where each block stands."""

from pathlib import Path

import rsegen

scene = rsegen.compose(rsegen.Recipe(name="pallet", seed=7, obstacles=[rsegen.Random(levels=5)]))
saw = rsegen.CutSettings(stock_cm=240, kerf_mm=3)
Path("pallet.pdf").write_bytes(rsegen.sheet(scene, saw))
Path("pallet.csv").write_bytes(rsegen.sheet(scene, saw, "csv"))
print(*Path("pallet.csv").read_text("utf-8").splitlines()[:10], sep="\n")
