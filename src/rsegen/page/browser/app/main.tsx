/* The page: edits a document of a server, or shows the maps that are frozen into it. */

import { render } from "preact";
import { useEffect } from "preact/hooks";
import { Bar, Status, TOOLS, ToolOptions, takeTool } from "./bar";
import { Modal, Segmented, Select, undo } from "./controls";
import { Banners, Open, SaveAs, dropped } from "./files";
import { MapPanel } from "./map";
import { Obstacles, removeSelected } from "./obstacles";
import "./page.css";
import { Results, Variants } from "./results";
import { play } from "./playback";
import { RobotPanel } from "./robot";
import { Jobs, Run } from "./run";
import { manual } from "./server";
import { Stage } from "./viewer";
import * as state from "./state";
import type { View } from "./views";

const { dialog, edit, frozen, layout, save, scene, selected, start, tab, tool } = state;

declare global {
  interface Window { rsegen: { solid?: View; plan?: View; state: typeof state } }
}
window.rsegen = { state };

const PANELS = { obstacles: Obstacles, map: MapPanel, robot: RobotPanel, results: Results };
const TABS = [["obstacles", "Obstacles"], ["map", "Map"], ["robot", "Robot"], ["results", "Results"]] as const;

/* The panels beside the map; on a narrow window one at a time, on a phone below the map. */
function Panels() {
  const wide = layout.value === "wide";
  const shown = wide && tab.value === "obstacles" ? "map" : tab.value;
  const Panel = PANELS[shown];
  return (
    <>
      {wide && <aside class="left" aria-label="Obstacles"><Obstacles /></aside>}
      <aside class="right" aria-label="Parameters and results">
        <nav aria-label="Panels"><Segmented name="Panel" value={shown} choices={wide ? TABS.slice(1) : TABS} onChange={(next) => (tab.value = next)} /></nav>
        <Panel />
      </aside>
    </>
  );
}

function Help() {
  return (
    <Modal title="Help" close={() => (dialog.value = null)}>
      <p class="lead">A map is a field of wooden blocks. <b>Add</b> puts an obstacle on it; where obstacles overlap, the later one replaces the earlier one. <b>Generate</b> writes its world for Gazebo.</p>
      <dl class="keys">
        {TOOLS.map((each) => <div key={each.key}><dt><kbd>{each.key.toUpperCase()}</kbd></dt><dd>{each.label}: {each.title[0]!.toLowerCase() + each.title.slice(1)}</dd></div>)}
        <div><dt><kbd>0</kbd> … <kbd>9</kbd></dt><dd>level to paint with. To copy a real pallet: press an arrow key on the view or the plan, then type the level of each cell, row by row; Backspace goes back</dd></div>
        <div><dt>arrow keys, <kbd>Enter</kbd> on the map</dt><dd>with Paint, Draw and Way: go to a cell, and do there what a click does; Home goes to the north-west cell. With Robot: move it, with Shift turn it. With Select: turn the view, <kbd>+</kbd> <kbd>-</kbd> zoom</dd></div>
        <div><dt><kbd>Ctrl Z</kbd> <kbd>Ctrl Y</kbd></dt><dd>undo, redo</dd></div>
        <div><dt><kbd>Ctrl S</kbd> <kbd>Ctrl O</kbd></dt><dd>save, open a recipe</dd></div>
        <div><dt><kbd>Ctrl Enter</kbd></dt><dd>generate the maps</dd></div>
        <div><dt><kbd>Delete</kbd> <kbd>Ctrl D</kbd></dt><dd>remove, or duplicate, the selected obstacle</dd></div>
        <div><dt><kbd>Alt ↑</kbd> <kbd>Alt ↓</kbd></dt><dd>move the selected obstacle up or down in the list</dd></div>
        <div><dt><kbd>Tab</kbd> on the map</dt><dd>go to the ends, the middle and the height of the selected obstacle; arrow keys move them by one cell or level, with Shift by one chunk</dd></div>
        <div><dt>drag, wheel</dt><dd>drag next to the map, or with the right mouse button, to turn the view; zoom with the wheel</dd></div>
        <div><dt>drop a file</dt><dd>opens a recipe; makes a map from a point cloud, a table or an image</dd></div>
      </dl>
      <p class="note">Levels: 5 levels of 10 cm are the heights 0, 10, 20, 30 and 40 cm. Numbers may have a decimal point or a decimal comma. rsegen {state.hello.value?.version}</p>
      <p><a href={manual()} target="_blank">Manual of all commands, their options, and all kinds of obstacles</a></p>
    </Modal>
  );
}

function Dialog() {
  const now = dialog.value;
  switch (now?.name) {
    case "open": return <Open />;
    case "save": return <SaveAs />;
    case "help": return <Help />;
    case "variants": return <Variants />;
    case "jobs": return <Jobs />;
    case "run": return <Run key={`${now.command} ${now.target}`} name={now.command} upload={now.upload} target={now.target} />;
    default: return null;
  }
}

function isTyping(target: EventTarget | null): boolean {
  return target instanceof HTMLElement && target.matches("input:not([type=range],[type=radio],[type=checkbox]), textarea, select");
}

function keys(event: KeyboardEvent): void {
  if (document.querySelector("dialog[open], :popover-open")) return; // they close by Escape
  const key = event.key.toLowerCase();
  const does = (work: () => unknown) => { event.preventDefault(); work(); };
  if (event.ctrlKey || event.metaKey) {
    if (key === "z") does(() => (event.shiftKey ? edit({ do: "redo" }) : undo()));
    else if (key === "y") does(() => edit({ do: "redo" }));
    else if (key === "s") does(() => (event.shiftKey ? (dialog.value = { name: "save" }) : save()));
    else if (key === "o") does(() => (dialog.value = { name: "open" }));
    else if (key === "d" && selected.value >= 0) does(() => edit({ do: "duplicate", row: selected.value }));
    else if (key === "enter") does(() => (dialog.value = { name: "run", command: "generate" }));
    else if (key === "r" && event.altKey) does(() => edit({ do: "reroll" }));
    return;
  }
  if (isTyping(event.target) || event.altKey || event.defaultPrevented) return;
  const named = TOOLS.find((each) => each.key === key);
  if (named) does(() => takeTool(named.name));
  else if (key === "delete" && selected.value >= 0) does(removeSelected);
  else if (key === "?") does(() => (dialog.value = { name: "help" }));
  else if (key === "escape") does(() => (tool.value.name === "select" ? (selected.value = -1) : takeTool("select")));
  else if (/^\d$/.test(key) && tool.value.name === "paint") does(() => tool.value.name === "paint" && (tool.value = { ...tool.value, level: Number(key) }));
}

function Editor() {
  useEffect(() => {
    addEventListener("keydown", keys);
    addEventListener("dragover", (event) => event.dataTransfer?.types.includes("Files") && event.preventDefault());
    addEventListener("drop", (event) => {
      const file = event.dataTransfer?.files[0];
      if (file) { event.preventDefault(); void dropped(file); }
    });
  }, []);
  const now = state.state.value;
  useEffect(() => void (document.title = now ? `${now.unsaved ? "• " : ""}${now.title} – rsegen` : "rsegen"), [now?.title, now?.unsaved]);
  return (
    <div class={`page ${layout.value}`}>
      <Bar />
      <Banners />
      {layout.value !== "wide" && <ToolOptions />}
      <Stage />
      <Panels />
      <Status />
      <Dialog />
    </div>
  );
}

/* A name by which maps of one recipe differ also if it is cut: long ones without their middle. */
const endsOf = (name: string) => (name.length > 20 ? `${name.slice(0, 8)}…${name.slice(-10)}` : name);

/* The frozen page: its maps, without anything that edits. */
function Viewer() {
  const { maps, version } = frozen!;
  const map = scene.value;
  const at = Math.max(0, maps.findIndex((each) => each === map));
  return (
    <div class={`page frozen ${layout.value}`}>
      <header class="top">
        <h1 title={map?.name}>{map?.name}</h1>
        <p title={map?.description}>{map?.description}</p>
        <span class="gap" />
        {maps.length > 1 && <Select name="Map" value={String(at)} choices={maps.map((each, number) => [String(number), endsOf(each.name)] as const)} onChange={(number) => (scene.value = maps[Number(number)]!)} />}
      </header>
      <Stage />
      <aside class="right" aria-label="Results"><Results /></aside>
      <Status note={`made by rsegen ${version}`} />
    </div>
  );
}

const driven = new URLSearchParams(location.search).get("play"); // the folder of a drive that rsegen gui was given

render(frozen ? <Viewer /> : <Editor />, document.getElementById("page")!);
void start().then(async () => { if (driven) await play(driven); });
