/* The bar on top: the file, undo, tools, and what may be run; and the line of status below. */

import { Button, Icon, Menu, NumberInput, Progress, Segmented, Select, hasUnreadable, undo } from "./controls";
import { times } from "./exact";
import type { DescribedCommand } from "./protocol";
import { leaveFor } from "./files";
import { offer, titleOf } from "./run";
import { copy } from "./results";
import { MapChooser } from "./map";
import { manual } from "./server";
import {
  busy, chooseRobot, counted, dialog, drawnKind, edit, frozen, heading, hello, hover, jobs, layout, problem, robot, rowAt, said, save, scene, selected, state, stays, tab, told, tool,
} from "./state";
import type { Tool } from "./views";

export const TOOLS: { key: string; name: Tool["name"]; label: string; title: string; make: () => Tool }[] = [
  { key: "v", name: "select", label: "Select", title: "Select an obstacle; drag its ends and its height", make: () => ({ name: "select" }) },
  { key: "p", name: "paint", label: "Paint", title: "Set the level of cells", make: () => ({ name: "paint", shape: "cells", level: 1 }) },
  { key: "d", name: "draw", label: "Draw", title: "Draw a new obstacle: drag from its first cell to its last, or press Enter at both", make: () => ({ name: "draw" }) },
  { key: "r", name: "robot", label: "Robot", title: "Show how the robot stands under the mouse, or at the arrow keys", make: () => ({ name: "robot", heading: heading.value }) },
  { key: "w", name: "way", label: "Way", title: "Find the robot's best way: click its start, then its goal, or press Enter there", make: () => ({ name: "way" }) },
];

/* Take a tool; those of a robot choose the first one if none is chosen. */
export function takeTool(name: Tool["name"]): void {
  if (name === "robot" || name === "way") {
    const first = hello.value?.robots[0];
    if (!robot.value && first) void chooseRobot(first.name);
    tab.value = "robot";
  }
  if (name === "draw") drawnKind.value = drawable().find((kind) => kind.name === rowAt(selected.value)?.entry.kind)?.name ?? drawnKind.value;
  stays.value = false;
  tool.value = TOOLS.find((each) => each.name === name)!.make();
}

function Tools() {
  return (
    <div class="tools" role="toolbar" aria-label="Tools">
      {TOOLS.map(({ key, name, label, title }) => (
        <Button key={name} icon={name} class="quiet" title={`${label}: ${title} (${key.toUpperCase()})`} pressed={tool.value.name === name}
          disabled={(name === "robot" || name === "way") && !robot.value && !hello.value?.robots.length} onClick={() => takeTool(name)} />
      ))}
    </div>
  );
}

/* Kinds that lie between two cells; a matrix is painted. */
const drawable = () => hello.value?.kinds.filter((kind) => kind.name !== "matrix") ?? [];

/* What the tools paint and draw with. */
export function ToolOptions() {
  const now = tool.value;
  if (now.name === "draw")
    return <section class="paint" aria-label="Draw"><Select name="Type to draw" value={drawnKind.value} onChange={(kind) => (drawnKind.value = kind)}
      choices={drawable().map((kind) => [kind.name, kind.title, kind.help] as const)} /></section>;
  if (now.name !== "paint") return null;
  const highest = Math.max(5, now.level, ...(scene.value?.palette.map((each) => each.level ?? 0) ?? []));
  const unit = Number(state.value?.values.unit_cm ?? 10);
  return (
    <section class="paint" aria-label="Paint">
      <Segmented name="Brush" value={now.shape} onChange={(shape) => (tool.value = { ...now, shape })}
        choices={[["cells", "Cells", "cell by cell"], ["rectangle", "Rectangle", "a rectangle"], ["fill", "Fill", "connected cells of one level"], ["pick", "Pick", "paint with the level of the cell that you click"]]} />
      <Segmented name="Level" value={String(now.level)} onChange={(level) => (tool.value = { ...now, level: Number(level) })}
        choices={[["-1", "erase", "remove the paint"], ...Array.from({ length: Math.min(10, highest + 1) }, (_, level) => [String(level), String(level), `${times(unit, level)} cm`] as const)]} />
      <label class="number">level <NumberInput id="paint-level" value={now.level < 0 ? undefined : now.level} whole placeholder="erase" minimum={0}
        onChange={(level) => Number(level) >= 0 && (tool.value = { ...now, level: Number(level) })} /></label>
    </section>
  );
}

/* Download the 3D view in twice the size in which it is shown. */
async function savePicture(): Promise<void> {
  const { clientWidth, clientHeight } = document.querySelector(".solid .view")!;
  const picture = await window.rsegen.solid?.picture(2 * clientWidth, 2 * clientHeight);
  if (picture) offer(picture, `${scene.value?.name}.png`);
}

function RunMenu() {
  const groups = new Map<string, DescribedCommand[]>();
  for (const command of hello.value?.commands ?? []) groups.set(command.group, [...(groups.get(command.group) ?? []), command]);
  return (
    <Menu label="Run" icon="play" title="Run a command on this map" class="run" wide>
      {[...groups].map(([group, commands]) => (
        <div role="group" aria-label={group} key={group}>
          <h2>{group}</h2>
          {commands.map((command) => <button type="button" key={command.name} onClick={() => (dialog.value = { name: "run", command: command.name })}><span>{command.title}<small>{command.help}</small></span></button>)}
        </div>
      ))}
    </Menu>
  );
}

export function Bar() {
  const now = state.value;
  return (
    <header class="top">
      <h1 class="hidden">{now?.title ?? "rsegen"}</h1>
      <Menu label={<span class="title" title={now?.title}>{now?.title ?? "rsegen"}{now?.unsaved && <span class="unsaved" title="unsaved changes"> •<span class="hidden"> unsaved changes</span></span>}</span>} title="File" class="file quiet">
        <button type="button" onClick={() => void leaveFor("")}>New</button>
        <button type="button" onClick={() => (dialog.value = { name: "open" })}>Open … <kbd>Ctrl O</kbd></button>
        <button type="button" onClick={() => void save()}>Save <kbd>Ctrl S</kbd></button>
        <button type="button" onClick={() => (dialog.value = { name: "save" })}>Save as …</button>
        <button type="button" disabled={!scene.value} onClick={() => void savePicture()}>Download a picture of the 3D view</button>
        <button type="button" onClick={() => void copy(location.href)}>Copy the address of this page</button>
        <button type="button" onClick={() => (dialog.value = { name: "help" })}>Help <kbd>?</kbd></button>
        <a class="button" href={manual()} target="_blank">Manual of all commands</a>
      </Menu>
      <div class="row quick">
        <Button icon="undo" class="quiet" title="Undo (Ctrl+Z)" disabled={!now?.can_undo && !hasUnreadable.value} onClick={undo} />
        <Button icon="redo" class="quiet" title="Redo (Ctrl+Y)" disabled={!now?.can_redo} onClick={() => void edit({ do: "redo" })} />
      </div>
      <Tools />
      {layout.value === "wide" && <ToolOptions />}
      <span class="gap" />
      {layout.value !== "phone" && <Button class="quiet" title="Save the recipe (Ctrl+S)" disabled={!now?.unsaved && Boolean(now?.path)} onClick={() => void save()}>Save</Button>}
      {layout.value !== "phone" && <Button icon="help" class="quiet" title="Help (?)" onClick={() => (dialog.value = { name: "help" })} />}
      <RunMenu />
    </header>
  );
}

export function Status({ note }: { note?: string }) {
  const [at, map, now] = [hover.value, scene.value, state.value];
  const running = jobs.value.filter((job) => job.state === "running");
  const owner = at && at.row >= 0 ? rowAt(at.row)?.entry.kind : null;
  const size = map?.facts.find(([name]) => name === "size")?.[1];
  const warnings = (map?.warnings ?? []).map(counted);
  return (
    <footer class="status">
      <span class="hover">{at ? <>{at.cell ? `cell ${at.cell.join(", ")}` : "frame"} <b>{at.label}</b>{owner ? ` ${at.row + 1} ${String(owner).replaceAll("_", " ")}` : ""}</> : size}</span>
      <MapChooser />
      {!frozen && now && <span class="seed">seed <code>{String(now.values.seed ?? "–")}</code><Button icon="dice" class="quiet" title="Draw another seed (Ctrl+Alt+R)" onClick={() => void edit({ do: "reroll" })} /></span>}
      {warnings.length > 0 && <span class="warning" title={warnings.join("\n")}><Icon name="warn" /> <span>{warnings.length === 1 ? warnings[0] : `${warnings.length} warnings`}</span></span>}
      <span class="gap" />
      {running[0] && <button type="button" class="quiet running" onClick={() => (dialog.value = { name: "jobs" })}>{titleOf(running[0].command)} {running[0].step} <Progress job={running[0]} /></button>}
      {!running[0] && jobs.value[0] && <button type="button" class="quiet" title="Commands that you ran, and their results" onClick={() => (dialog.value = { name: "jobs" })}>Runs</button>}
      {problem.value && !problem.value.kind && <span class="problem" role="alert"><Icon name="warn" /> {told(problem.value)}
        <Button icon="close" class="quiet" title="Dismiss" onClick={() => (problem.value = null)} /></span>}
      <span class="said" role="status">{note || said.value || (busy.value > 0 ? "…" : "")}</span>
    </footer>
  );
}
