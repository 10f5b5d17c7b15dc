/* The map: its 3D view, and the plan as an inset or as half of the stage. Both follow the signals, and report the mouse. */

import { effect } from "@preact/signals";
import { useEffect, useRef } from "preact/hooks";
import { Button, Segmented } from "./controls";
import { add, kindOf } from "./obstacles";
import { Plan } from "./plan";
import { Solid } from "./solid";
import {
  changeEntry, crossing, dark, drawing, drawings, drawnKind, edit, face, frozen, ghost, heading, hello, hover, isCramped, layout, mapShown, options, plan, playbacks, pose, poseMap, reach, rowAt, scene,
  second, selected, settle, state, stays, told, tool, way, wayPoint, wayStart,
} from "./state";
import { best } from "./robot";
import { Timeline } from "./playback";
import type { Tool, View, ViewEvents } from "./views";

const never: Tool = { name: "select" };

const editing: ViewEvents = {
  hover: (at) => (hover.value = at),
  pick: (row) => (selected.value = row),
  chunk: () => Number(state.value?.values.chunk_size ?? 10),
  moveEnd: (row, end, cell, gesture) => void edit({ do: "move_end", row, end, cell, gesture }),
  raise: (row, levels, gesture) => changeEntry(row, "levels", levels, gesture),
  paint: (painted, level, gesture) => void edit({ do: "paint", row: paintedRow(), cells: painted, level, gesture }),
  picked: (level) => (tool.value = { name: "paint", shape: "cells", level }),
  draw: (first, last) => {
    const kind = kindOf(drawnKind.value) ?? hello.value?.kinds[0];
    if (kind) add(kind, { first, last });
    tool.value = { name: "select" };
  },
  robotAt: (x, y) => { if (!stays.value) settle(x, y); },
  robotPut: (x, y) => {
    stays.value = true;
    settle(x, y);
  },
  turn: (by) => face(heading.value + by),
  wayPoint: (x, y) => void wayPoint(x, y, best.value),
};
const looking: ViewEvents = { hover: editing.hover };

/* Paint goes into the selected matrix, or into a new one. */
const paintedRow = () => (rowAt(selected.value)?.entry.kind === "matrix" ? selected.value : -1);

/* Make a view in its element, and let it follow the signals; what it draws is the value of each. */
function follow(view: View, player: number): () => void {
  const ends = [
    effect(() => view.show(scene.value)),
    effect(() => view.set({ ...options.value, dark: dark.value })),
    effect(() => view.tool(frozen || playbacks.value.length ? never : tool.value)),
    effect(() => view.select(selected.value)),
    effect(() => view.ghost(ghost.value?.scene ?? null, ghost.value?.row ?? -1)),
    effect(() => view.robot(drawing.value, playbacks.value.length ? null : pose.value)),
    effect(() => view.poseMap(poseMap.value, mapShown.value)),
    effect(() => view.reach(reach.value, crossing.value)),
    effect(() => view.way(way.value, wayStart.value)),
    // A drive is on its map: without one there is nothing to drive on, and the sizes of its marks are those of cells.
    effect(() => view.play((scene.value && playbacks.value[player]) ?? null, drawings.value)),
    effect(() => { if (scene.value && playbacks.value[player]) view.at(second.value); }),
  ];
  return () => {
    ends.forEach((end) => end());
    view.dispose();
  };
}

type Of = new (host: HTMLElement, on: ViewEvents) => View;

function Host({ of: Of, label, player = 0, name }: { of: Of; label: string; player?: number; name?: "solid" | "plan" }) {
  const host = useRef<HTMLDivElement>(null);
  const trouble = useRef<HTMLParagraphElement>(null);
  useEffect(() => {
    try {
      const view = new Of(host.current!, frozen ? looking : editing);
      if (name) window.rsegen[name] = view;
      return follow(view, player);
    } catch (error) {
      console.warn(error); // a browser without WebGL still has the plan and all forms
      trouble.current!.hidden = false;
    }
  }, []);
  return <div class="view" ref={host} role="region" aria-label={label}><p ref={trouble} hidden class="empty">This browser cannot show 3D graphics: WebGL 2 is missing or switched off.</p></div>;
}

const LOOKS = [["oblique", "Oblique"], ["above", "Above"], ["south", "South"], ["east", "East"]] as const;

/* Width over height of the plan as an inset: that of the map, within bounds. */
function aspect(): number {
  const [x, y] = scene.value?.cells ?? [1, 1];
  return Math.min(2.2, Math.max(0.6, (x + 4) / (y + 4))); // four cells of room for numbers
}

/* Whether the recipe shows wood or friction, which are no colours of heights. */
const hasMaterial = () => scene.value?.palette.some(({ level, colour, surface }) => level && colour !== surface) ?? false;

const MOST_ROWS = { wide: 7, narrow: 7, phone: 4 }; // of heights in a legend

/* What the colours of the blocks mean, wherever they mean heights: the highest first, of many levels some; then the
   ground and the frame. While the 3D view shows materials, they are those of the plan, if there is one. */
function HeightLegend({ hasPlan }: { hasPlan: boolean }) {
  const map = scene.value;
  const isOfPlan = hasMaterial() && options.value.look !== "heights";
  if (!map || (isOfPlan && !hasPlan)) return null;
  const levels = map.palette.filter((each) => each.level).reverse();
  const rows = Math.min(MOST_ROWS[layout.value], levels.length);
  const shown = levels.filter((_, at) => rows === levels.length || Array.from({ length: rows }, (_, k) => Math.round((k * (levels.length - 1)) / (rows - 1))).includes(at));
  const others = map.palette.filter((each) => !each.level).reverse(); // the ground, and the frame
  return (
    <ul class="over legend heights-legend" aria-label={`Colours of heights${isOfPlan ? " on the plan" : ""}, ${map.unit}`}>
      {isOfPlan && <li>on the plan</li>}
      {[...shown, ...others].map((each) => (
        <li key={each.level} class="key"><i style={{ background: each.colour }} />{each.level === null ? "frame" : `${each.label} ${map.unit}`}</li>))}
    </ul>
  );
}

export function Stage() {
  const two = playbacks.value.length > 1;
  const halved = useRef(false);
  const isOver = playbacks.value.length > 0 && isCramped.value; // a plan in the corner would hide the drive
  const given = isOver && plan.value === "inset" ? "hidden" : plan.value;
  const isHalf = two || given === "half";
  useEffect(() => {
    // A view that becomes half as wide, or whole again, shows the whole map.
    if (halved.current !== isHalf) requestAnimationFrame(() => window.rsegen.solid?.look("oblique"));
    halved.current = isHalf;
  }, [isHalf]);
  return (
    <main class={`stage plan-${given} ${two ? "two" : ""}`} aria-label="Map">
      <div class="solid">
        <Host of={Solid} label="3D view" name="solid" />
        {two && <Host of={Solid} label="3D view of the second drive" player={1} />}
        <div class="over look">
          <div class="bar" role="group" aria-label="Look from">
            {LOOKS.map(([from, label]) => <Button key={from} class="quiet" title={`Look ${from === "above" ? "from above, north up" : from === "oblique" ? "from the south-east" : `from the ${from}`}`} onClick={() => window.rsegen.solid?.look(from)}>{label}</Button>)}
          </div>
          {hasMaterial() && <Segmented name="Colours" value={options.value.look ?? "recipe"} choices={[["recipe", "Material", "as in Gazebo"], ["heights", "Heights", "one colour for each height"]]}
            onChange={(look) => (options.value = { ...options.value, look })} />}
        </div>
        <HeightLegend hasPlan={given !== "hidden"} />
        {!scene.value && <p class="over empty">Drawing the map …</p>}
        {state.value?.problem && <p class="over stale" role="status">This is the last valid map. {told(state.value.problem)}</p>}
      </div>
      {given !== "hidden" && (
        <section class="plan" aria-label="Plan" style={{ "--aspect": aspect() }}>
          <Host of={Plan} label="Plan, north up" name="plan" />
          <div class="over corner">
            <Button class="quiet" icon={given === "inset" ? "grow" : "shrink"} title={given === "inset" ? "Show the plan in half of the window" : isOver ? "Hide the plan" : "Show the plan small"} onClick={() => (plan.value = plan.value === "inset" ? "half" : "inset")} />
            <Button class="quiet" icon="close" title="Hide the plan" onClick={() => (plan.value = "hidden")} />
          </div>
        </section>
      )}
      {given === "hidden" && <Button class="over show-plan" icon="grow" title="Show the plan" onClick={() => (plan.value = isOver ? "half" : "inset")}>Plan</Button>}
      <Timeline />
    </main>
  );
}
