"""Random actions on the page, in a real browser against a real server, with every invariant checked after each.

People add, type, drag, paint, switch, move, undo and save; another page edits the same document meanwhile. After each
action the console is empty, the page shows what the server has, the list is the recipe, the map is the one that Python
builds, and the file has changed only if it was saved. In the end everything is undone and done again.
"""

from __future__ import annotations

import json
import random
from base64 import b64decode
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest

from rsegen.page.forms import title_of
from rsegen.page.host import Host
from rsegen.page.service import Service
from rsegen.recipe.building import build
from rsegen.recipe.codec import decode
from tests.page.client import TOKEN, Client
from tests.support.browser import BLURRED, chromium, complaints, resize
from tests.support.long import long_unless
from tests.support.patience import until

if TYPE_CHECKING:
    from selenium.webdriver import Chrome

pytestmark = pytest.mark.slow

_HELPERS = """
const { state, solid, plan } = window.rsegen;
const all = (selector) => [...document.querySelectorAll(selector)];
const pointer = (view, type, [x, y]) => {
  const { left, top } = view.canvas.getBoundingClientRect();
  const [button, buttons] = [type === "pointermove" ? -1 : 0, type === "pointerup" ? 0 : 1];
  const at = { clientX: left + x, clientY: top + y, bubbles: true, pointerId: 1, pointerType: "mouse" };
  view.canvas.dispatchEvent(new PointerEvent(type, { ...at, button, buttons }));
};
const drag = (view, from, to) => {
  if (!from || !to) return;
  const between = (part) => from.map((at, axis) => at + part * (to[axis] - at));
  pointer(view, "pointerdown", from);
  for (const part of [0.2, 0.5, 0.8, 1]) pointer(view, "pointermove", between(part));
  pointer(view, "pointerup", to);
};
const cell = (x, y) => plan.pixelOf(...plan.field.ofBlock([x % 12, y % 12]));
const type = (input, text) => {
  if (!input) return;
  input.focus();
  Object.getOwnPropertyDescriptor(HTMLInputElement.prototype, "value").set.call(input, text);
  input.dispatchEvent(new InputEvent("input", { bubbles: true }));
  input.blur();
};
const press = (key, more) => (all(".rows .pick")[more?.row] ?? document.body).dispatchEvent(
  new KeyboardEvent("keydown", { key, bubbles: true, cancelable: true, ...more }));
const pick = (row) => {
  const there = all(".rows .pick");
  if (there.length && state.selected.value !== row % there.length) there[row % there.length].click();
};
const field = (label) => all(`[data-field="${label}"] input[type=text]`)[0];
"""


FEW, MANY = 15, 60
REASON = "a trial takes half a minute"  # seed 5 once showed another map than the chosen one


@dataclass(kw_only=True)
class Trial:
    """A page, its server as another page sees it, and the file of the document."""

    chrome: Chrome
    client: Client
    address: str
    file: Path
    rng: random.Random
    log: list[str] = field(default_factory=list)
    written: bytes = b""

    def js(self, script: str, *arguments: object) -> Any:
        return self.chrome.execute_script(_HELPERS + script, *arguments)

    def open(self) -> None:
        resize(self.chrome, 1366, 768, sharpness=BLURRED)
        self.chrome.get("about:blank")
        complaints(self.chrome)  # of the page before
        self.chrome.get(f"{self.address}&open={self.file.name}")
        until(lambda: self.chrome.execute_script("return Boolean(window.rsegen?.state.scene.value)"))
        until(lambda: self.js("return Boolean(plan?.field && state.hello.value)"))
        self.written = self.file.read_bytes()

    @property
    def doc(self) -> str:
        doc: str = self.js("return state.doc()")
        return doc

    def settle(self) -> dict[str, Any]:
        """Wait until the page has sent everything and drawn the newest map; return the state of the server."""
        self.chrome.execute_async_script("window.rsegen.state.edit().then(arguments[arguments.length - 1])")
        held: dict[str, Any] = {}

        def is_settled() -> bool:
            held.update(self.client.call("state", doc=self.doc, index=self.js("return state.index.value")))
            known = self.js(
                "return state.busy.value === 0 && [state.state.value.revision, state.scene.value?.revision]"
            )
            return bool(known == [held["revision"], held["revision"]])

        until(is_settled)
        return held

    def number(self, most: int) -> int:
        return self.rng.randrange(most)


def _add(trial: Trial) -> None:
    trial.js("const kinds = all('.menu .kind'); kinds[arguments[0] % kinds.length].click()", trial.number(100))


def _type(trial: Trial) -> None:
    label = trial.rng.choice(["Height", "Softness", "X first", "Y last", "Weights", "Max step"])
    text = trial.rng.choice(["0", "1", "3", "6,5", "12", "30", "130", "abc", "", "2 1 1"])
    trial.js(
        "pick(arguments[2]);"
        "return new Promise(requestAnimationFrame).then(() => type(field(arguments[0]), arguments[1]))",
        label,
        text,
        trial.number(20),
    )


def _set(trial: Trial) -> None:
    label, text = trial.rng.choice(
        [
            *(("Chunk size", "10"), ("Chunk size", "7"), ("Number of maps", "3"), ("Number of maps", "1")),
            *(("Height step (unit)", "7,5"), ("Height step (unit)", "10"), ("Seed", str(2**63 - 1)), ("Seed", "4")),
            *(("Number of maps", "0"), ("Height step (unit)", "x"), ("Difficulty", "0.5"), ("Difficulty", "1")),
        ]
    )
    trial.js("state.tab.value = 'map'; type(field(arguments[0]), arguments[1])", label, text)


def _drag(trial: Trial) -> None:
    trial.js(
        "pick(arguments[0]); return new Promise(requestAnimationFrame).then(() => {"
        "const there = plan.handles(); drag(plan, there[arguments[1]], cell(arguments[2], arguments[3])) })",
        trial.number(20),
        trial.rng.choice(["first", "last", "both"]),
        trial.number(12),
        trial.number(12),
    )


def _raise(trial: Trial) -> None:
    trial.js(
        "pick(arguments[0]); return new Promise(requestAnimationFrame).then(() => {"
        "const at = solid.handles().raise; if (at) drag(solid, at, [at[0], at[1] + arguments[1]]) })",
        trial.number(20),
        trial.number(120) - 60,
    )


def _paint(trial: Trial) -> None:
    trial.js(
        "state.tool.value = { name: 'paint', shape: arguments[0], level: arguments[1] };"
        "drag(plan, cell(arguments[2], arguments[3]), cell(arguments[4], arguments[5]));"
        "state.tool.value = { name: 'select' }",
        trial.rng.choice(["cells", "rectangle", "fill"]),
        trial.number(14) - 1,
        *(trial.number(12) for _ in range(4)),
    )


def _draw(trial: Trial) -> None:
    places = [trial.number(12) for _ in range(4)]
    trial.js(
        "state.tool.value = { name: 'draw' };"
        "drag(plan, cell(arguments[0], arguments[1]), cell(arguments[2], arguments[3]))",
        *places,
    )


def _press(trial: Trial) -> None:
    key, more = trial.rng.choice(
        [
            *(("Delete", {}), ("d", {"ctrlKey": True}), ("r", {"ctrlKey": True, "altKey": True}), ("Escape", {})),
            *(
                ("ArrowDown", {"altKey": True, "row": 0}),
                ("ArrowUp", {"altKey": True, "row": 1}),
                ("ArrowDown", {"row": 0}),
            ),
        ]
    )
    trial.js("press(arguments[0], arguments[1])", key, more)


def _switch(trial: Trial) -> None:
    trial.js("const there = all('.rows .switch'); there[arguments[0] % (there.length || 1)]?.click()", trial.number(20))


def _undo(trial: Trial) -> None:
    trial.js("for (let k = 0; k < arguments[0]; k++) press('z', { ctrlKey: true })", 1 + trial.number(3))


def _redo(trial: Trial) -> None:
    trial.js("press('y', { ctrlKey: true })")


def _show_map(trial: Trial) -> None:
    trial.js("all('.chooser button:not(:disabled)')[0]?.click()")


def _blend(trial: Trial) -> None:
    trial.js(
        "const there = all('[data-field=Blend] input'); there[arguments[0] % (there.length || 1)]?.click()",
        trial.number(4),
    )


def _other_page(trial: Trial) -> None:
    entry = {"kind": "platform", "levels": 3, "first": [1, 1], "last": [trial.number(9), 3]}
    actions: list[dict[str, Any]] = trial.rng.choice(
        [[{"do": "add", "entry": entry}], [{"do": "undo"}], [{"do": "set", "name": "unit_cm", "value": 12}]]
    )
    trial.js("window.other = state.changeEntry && state.rowAt(0) && state.changeEntry(0, 'softness', arguments[0])", 40)
    trial.client.call("edit", doc=trial.doc, page="other", actions=actions)


def _save(trial: Trial) -> None:
    trial.settle()
    saved = trial.chrome.execute_async_script("window.rsegen.state.save().then(arguments[arguments.length - 1])")
    if saved:
        trial.written = trial.file.read_bytes()
    trial.js("state.problem.value = null")


_OFTEN = (_add, _type, _drag, _paint, _undo, _press)
_SOMETIMES = (_set, _raise, _switch, _redo)
_SELDOM = (_draw, _blend, _show_map, _other_page, _save)
_ACTIONS = (*_OFTEN, *_OFTEN, *_SOMETIMES, *_OFTEN, *_SOMETIMES, *_SELDOM)


def _check(trial: Trial) -> None:
    """Check every invariant of a page on which nothing is under way."""
    held = trial.settle()
    said = [each for each in complaints(trial.chrome) if "frame-ancestors" not in each and "status of 4" not in each]
    assert said == []
    shown = json.loads(
        trial.js("return JSON.stringify(state.state.value, (k, v) => typeof v === 'bigint' ? `big ${v}` : v)"),
    )
    big = json.loads(json.dumps(held), parse_int=lambda text: int(text) if len(text) < 17 else f"big {text}")
    for name in ("revision", "values", "rows", "problem", "maps", "unsaved", "title", "can_undo", "can_redo"):
        assert shown[name] == big[name], name
    listed = trial.js(
        "return all('.rows li').map((each) =>"
        " [each.querySelector('.what').firstChild.textContent, !each.classList.contains('off')])"
    )
    assert listed == [[title_of(row["entry"]["kind"]), row["enabled"]] for row in held["rows"]]
    assert -1 <= trial.js("return state.selected.value") < len(held["rows"])
    if held["problem"] is None:
        _check_map(trial, held)
    assert trial.file.read_bytes() == trial.written


def _check_map(trial: Trial, held: Mapping[str, Any]) -> None:
    """Check that the map that is drawn is the one that Python builds of the list."""
    scene = trial.js(
        "const { content, bytes, cells, palette } = state.scene.value; return { content, bytes, cells, palette }"
    )
    drawn = np.frombuffer(b64decode(scene["content"]), "<u2" if scene["bytes"] == 2 else "u1").reshape(scene["cells"])
    levels = np.array([-1 if each["level"] is None else each["level"] for each in scene["palette"]])[drawn]
    obstacles = [{**row["entry"], **({} if row["enabled"] else {"enabled": False})} for row in held["rows"]]
    made = build(decode({**held["values"], "obstacles": obstacles}), trial.js("return state.index.value"))
    np.testing.assert_array_equal(levels, np.where(made.frame, -1, made.levels))


@pytest.fixture(scope="module")
def chrome() -> Iterator[Chrome]:
    with chromium() as opened:
        opened.set_script_timeout(60)
        yield opened


@pytest.mark.parametrize(
    ("seed", "actions"),
    long_unless(lambda case: case[1] == FEW, [(0, FEW), (5, MANY)], reason=REASON),
)
def test_every_invariant_holds_after_random_actions(chrome: Chrome, tmp_path: Path, seed: int, actions: int) -> None:
    file = tmp_path / "course.yaml"
    file.write_text(
        "# a course\nname: course\nseed: 7\nmaps: 2\nchunk_size: 12\n"
        "obstacles:\n  - kind: random  # rough\n    levels: 4\n"
    )
    service = Service(host=Host(folder=tmp_path), port=0, keep=True, token=TOKEN)
    service.start()
    try:
        trial = Trial(
            chrome=chrome,
            client=Client(service.listening_port),
            address=service.url(),
            file=file,
            rng=random.Random(seed),  # noqa: S311  # not for secrets
        )
        trial.open()
        try:
            _play(trial, actions)
        except Exception as error:
            raise AssertionError(f"seed {seed}, after {', '.join(trial.log[-12:])}: {error}") from error
    finally:
        chrome.get("about:blank")
        service.close()


def _play(trial: Trial, actions: int) -> None:
    before = trial.settle()
    _check(trial)
    for _ in range(actions):
        act = trial.rng.choice(_ACTIONS)
        trial.log.append(act.__name__.strip("_"))
        act(trial)
        _check(trial)
    end = _moved_to_the_end(trial, "redo")
    assert _moved_to_the_end(trial, "undo") == _draft(before)
    assert _moved_to_the_end(trial, "redo") == end


def _moved_to_the_end(trial: Trial, direction: str) -> Any:
    """Undo or redo everything, check the page, and return the draft."""
    trial.log.append(f"{direction} all")
    while trial.settle()[f"can_{direction}"]:
        trial.js("press(arguments[0], { ctrlKey: true })", {"undo": "z", "redo": "y"}[direction])
    _check(trial)
    return _draft(trial.settle())


def _draft(held: Mapping[str, Any]) -> Any:
    return held["values"], [(row["entry"], row["enabled"]) for row in held["rows"]]
