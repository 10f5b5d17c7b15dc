"""Things of one sort by their names, each imported when it is needed."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

from rsegen.errors import PluginError, UnknownName
from rsegen.params import registry
from rsegen.params.plugins import EntryPoint, Source, entry_points
from rsegen.params.registry import Contract, Registry

PRICES = Contract(base=int, names=lambda price: (f"for {price}",), is_class=False)


def fruits() -> Registry[int]:
    found: Registry[int] = Registry("fruit", contract=PRICES)
    for name, price in (("pear", 3), ("apple", 5), ("fig", 1)):
        found.add(name, price)
    return found


def test_a_registry_lists_names_in_order() -> None:
    assert dict(fruits()) == {"pear": 3, "apple": 5, "fig": 1}
    assert list(fruits()) == ["apple", "fig", "pear"]
    dearest: Registry[int] = Registry("fruit", order=lambda price: -price, contract=PRICES)
    for name, price in fruits().items():
        dearest.add(name, price)
    assert list(dearest) == ["apple", "pear", "fig"]


def test_what_is_registered_is_kept_under_the_names_of_the_contract_and_returned() -> None:
    found = fruits()
    assert found.register(7) == found["for 7"] == 7


def test_a_registry_shows_its_names() -> None:
    assert repr(fruits()) == "<fruit: apple, fig, pear>"


def test_two_of_one_name_are_a_mistake() -> None:
    with pytest.raises(TypeError, match="two fruits are named 'fig': 1 and 2"):
        fruits().add("fig", 2)


@pytest.mark.parametrize("name", ["figg", ["fig"], None])
def test_an_unknown_name_is_refused_with_the_known_ones(name: object) -> None:
    with pytest.raises(UnknownName, match=r"basket: unknown fruit .* \(known: apple, fig, pear\)"):
        fruits().named(name, "basket")  # type: ignore[arg-type]
    assert fruits().named("fig", "basket") == 1


OFFER = EntryPoint(group="fruits", name="kiwi", value="string:digits", source=Source(name="orchard", version="2"))


def basket(monkeypatch: pytest.MonkeyPatch, *found: EntryPoint) -> Registry[str]:
    monkeypatch.setattr(registry, "entry_points", lambda: found)
    contract = Contract(base=str, names=lambda text: ("kiwi",), is_class=False)
    return Registry("fruit", group="fruits", contract=contract)


def test_an_entry_point_is_imported_on_use(monkeypatch: pytest.MonkeyPatch) -> None:
    found = basket(monkeypatch, OFFER)
    assert found["kiwi"] == "0123456789"
    assert str(found.source("kiwi")) == "orchard 2"
    assert list(found) == ["kiwi"]


def test_offers_of_another_group_are_ignored(monkeypatch: pytest.MonkeyPatch) -> None:
    offer = EntryPoint(group="vegetables", name="kiwi", value="string:digits", source=OFFER.source)
    assert "kiwi" not in basket(monkeypatch, offer)


def test_a_failed_import_is_reported_on_every_use(monkeypatch: pytest.MonkeyPatch) -> None:
    offer = EntryPoint(group="fruits", name="kiwi", value="string:peel", source=OFFER.source)
    found = basket(monkeypatch, offer)
    for _ in range(2):
        with pytest.raises(PluginError, match=r"plug-in 'kiwi' of orchard 2 \(string:peel\): AttributeError"):
            found.named("kiwi", "basket")


def test_only_the_file_that_is_called_like_a_format_is_imported() -> None:
    code = (
        "import sys; from rsegen.formats.base import FORMATS; FORMATS['stl'];"
        "home = 'rsegen.formats.'; print(home + 'stl' in sys.modules, home + 'usd' in sys.modules)"
    )
    found = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert found.stdout == "True False\n"


@pytest.mark.parametrize("text", ["rsegen-ramps 1.2", "ramp.py", "my ramp.py", "some.module"])
def test_a_source_is_read_back_as_it_is_written(text: str) -> None:
    assert str(Source.parse(text)) == text
    assert bool(Source.parse(text).version) == (text == "rsegen-ramps 1.2")


def test_of_two_versions_of_a_package_the_first_on_the_path_counts(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    for place, name in (("first", "or_chard-2.dist-info"), ("second", "Or.Chard-1.egg-info")):
        (tmp_path / place / name).mkdir(parents=True)
        (tmp_path / place / name / "METADATA").write_text("Metadata-Version: 2.1\nName: or-chard\nVersion: 2\n")
        (tmp_path / place / name / "entry_points.txt").write_text("[rsegen.fruits]\nkiwi = string:digits\n")
    monkeypatch.setattr(sys, "path", [str(tmp_path / "nowhere"), str(tmp_path / "first"), str(tmp_path / "second")])
    (found,) = entry_points.__wrapped__()
    assert str(found) == "plug-in 'kiwi' of or-chard 2 (string:digits)"
