/* The obstacles of the recipe: the list, in the order in which they are imposed, and the form of the selected one. */

import { useEffect, useId, useRef, useState } from "preact/hooks";
import { Button, Icon, Labelled, Menu, Segmented, Select, Slider, Switch } from "./controls";
import { shown, times } from "./exact";
import { Form } from "./fields";
import type { Cell, Entry, Json, Kind, Row } from "./protocol";
import {
  HEADINGS, cells, changeEntry, edit, hello, index, newGesture, problemAt, rowAt, scene, selected, showGhost, state, tool,
} from "./state";

/* What a kind looks like from above or the side, for lists; kinds of plug-ins have a square. */
const SHAPES: { [kind: string]: string } = {
  diagonal_barrier: "M2.500 13.500 13.500 2.500M2.500 10 10 2.500M6 13.500 13.500 6",
  horizontal_barrier: "M1.500 6.500h13M1.500 9.500h13",
  peak: "M1.500 13 8 3l6.500 10z",
  random: "M2.500 13V9M6 13V4M9.500 13V7M13 13V2.500",
  normal_random: "M1.500 13c4 0 4-9 6.500-9s2.500 9 6.500 9",
  platform: "M2 13V6h12v7",
  matrix: "M2.500 2.500h11v11h-11zM2.500 8h11M8 2.500v11",
  pallet: "M2 13h3v-3h3V7h3V4h3",
};
const Shape = ({ kind }: { kind: string }) => (
  <svg class="icon shape" viewBox="0 0 16 16" aria-hidden="true"><path d={SHAPES[kind] ?? "M3 3h10v10H3z"} /></svg>
);

export const kindOf = (name: Json | undefined): Kind | undefined => hello.value?.kinds.find((kind) => kind.name === name);

/* An obstacle of a kind as it is added: with the defaults of the parameters that it needs. */
export function fresh(kind: Kind): Entry {
  const levels = kind.fields.find((field) => field.name === "levels")?.default;
  return { kind: kind.name, ...(levels !== undefined && levels !== null && { levels }), ...(!levels && kind.name !== "matrix" && { levels: 5 }) };
}

export function add(kind: Kind, place: { first?: Cell; last?: Cell } = {}): void {
  void edit({ do: "add", entry: { ...fresh(kind), ...place } });
}

export function removeSelected(): void {
  const count = state.value?.rows.length ?? 0;
  if (!count) return;
  const isInList = document.activeElement?.closest(".rows");
  void edit({ do: "remove", row: selected.value >= 0 ? selected.value : count - 1 }).then(() => isInList && setTimeout(focusList, 60)); // when it is drawn
}

/* Give the focus to the selected row, or if there is none to the button that adds one. */
function focusList(): void {
  document.querySelector<HTMLElement>(".rows .selected .pick, .obstacles:not(:has(.rows)) [title='Add an obstacle']")?.focus();
}

/* The heights that a number of levels stands for: 0, 10, 20 cm. */
function heights(levels: Json | undefined): string {
  const unit = state.value?.values.unit_cm;
  if (typeof levels !== "number" || typeof unit !== "number" || levels < 1) return "";
  const all = Array.from({ length: Math.min(levels, 6) }, (_, level) => String(times(unit, level)));
  const text = levels > 6 ? [...all.slice(0, 3), "…", String(times(unit, levels - 1))] : all;
  return `${text.join(", ")} cm`;
}

const capitalized = (text: string) => text[0]!.toUpperCase() + text.slice(1);
const pair = (place: Json | undefined): Json[] => (Array.isArray(place) ? place : ["random", "random"]);

const isFree = ({ entry }: Row) => entry.first === undefined && entry.last === undefined;

/* Where an obstacle without ends lies, by its kind: "on the whole map". */
const usualPlace = ({ entry }: Row): string => kindOf(entry.kind)?.default_place ?? "at a random position";
const isRandom = (row: Row) => usualPlace(row).includes("random");

function where(row: Row): string {
  const { entry } = row;
  if (isFree(row)) return isRandom(row) ? "random" : usualPlace(row).replace(/^on |^in |the /g, "");
  const text = (place: Json | undefined) => pair(place).map((at) => (at === "random" ? "?" : shown(at))).join(",");
  const [first, last] = [text(entry.first), text(entry.last)];
  return first === "?,?" && last === "?,?" ? "random" : `${first} → ${last}`;
}

export function Obstacles() {
  const rows = state.value?.rows ?? [];
  return (
    <section class="panel obstacles" aria-labelledby="obstacles-title">
      <header>
        <h2 id="obstacles-title">Obstacles <small>{rows.length || ""}</small></h2>
        <Button icon="remove" class="quiet" title="Remove the selected obstacle, or the last one (Delete)" disabled={!rows.length} onClick={removeSelected} />
        <Menu icon="more" class="quiet" title="More actions">
          <button type="button" disabled={selected.value < 0} onClick={() => void edit({ do: "duplicate", row: selected.value })}>Duplicate <kbd>Ctrl D</kbd></button>
          <button type="button" disabled={!rows.length} onClick={() => void edit({ do: "clear" })}>Remove all</button>
        </Menu>
        <Menu icon="add" label="Add" class="tinted" title="Add an obstacle" onClose={() => showGhost(null)}>
          {hello.value?.kinds.map((kind) => (
            <button type="button" class="kind" key={kind.name} onFocus={() => showGhost(kind.name === "matrix" ? null : fresh(kind))} onPointerEnter={(event) => event.currentTarget.focus()} onClick={() => (kind.name === "matrix" ? (tool.value = { name: "paint", shape: "cells", level: 1 }) : add(kind))}>
              <Shape kind={kind.name} /><span>{kind.title}<small>{kind.help.replaceAll("`", "")}</small></span>
            </button>
          ))}
        </Menu>
      </header>
      {rows.length ? <List rows={rows} /> : <p class="empty">The map is flat. Add an obstacle, or draw one on the map with <kbd>D</kbd>.</p>}
      {selected.value >= 0 && rowAt(selected.value) && <ObstacleForm key={selected.value} row={selected.value} />}
    </section>
  );
}

function List({ rows }: { rows: Row[] }) {
  const [dragged, drag] = useState(-1);
  const [over, goOver] = useState(-1);
  const list = useRef<HTMLOListElement>(null);
  useEffect(() => list.current?.querySelector(".selected")?.scrollIntoView({ block: "nearest" }), [selected.value]);
  const drop = () => {
    if (dragged >= 0 && over >= 0 && dragged !== over) void edit({ do: "move", row: dragged, to: over });
    drag(-1);
    goOver(-1);
  };
  const keys = (event: KeyboardEvent, row: number) => {
    const step = event.key === "ArrowDown" ? 1 : event.key === "ArrowUp" ? -1 : 0;
    const to = row + step;
    if (!step || to < 0 || to >= rows.length) return;
    event.preventDefault();
    if (event.altKey) void edit({ do: "move", row, to });
    else selected.value = to;
    const list = (event.currentTarget as HTMLElement).closest("ol")!;
    setTimeout(() => list.querySelectorAll<HTMLElement>(".pick")[to]?.focus(), event.altKey ? 120 : 0);
  };
  return (
    <ol class="rows" ref={list} style={{ "--digits": String(rows.length).length }} aria-label="Obstacles, in the order in which they are put on the map">
      {rows.map((row, at) => {
        const kind = kindOf(row.entry.kind);
        const wrong = [state.value?.problem?.where ?? ""].some((each) => each.startsWith(`obstacles[${at}]`));
        return (
          <li key={shown(row.entry.key) || at} class={`${at === selected.value ? "selected" : ""} ${row.enabled ? "" : "off"} ${at === over && dragged >= 0 ? (dragged < at ? "after" : "before") : ""}`}
            draggable onDragStart={(event) => { drag(at); event.dataTransfer!.effectAllowed = "move"; }} onDragEnd={drop}
            onDragOver={(event) => { if (dragged >= 0) { event.preventDefault(); goOver(at); } }}>
            <button type="button" class="pick" aria-current={at === selected.value} title="Select this obstacle. Arrow keys go to the next one; Alt and arrow keys move it in the list"
              onClick={() => (selected.value = at === selected.value ? -1 : at)} onKeyDown={(event) => keys(event, at)}>
              <span class="id">{at + 1}</span>
              <Shape kind={shown(row.entry.kind)} />
              <span class="what">{kind?.title ?? shown(row.entry.kind).replaceAll("_", " ")}<small>{where(row)}</small></span>
              {wrong && <Icon name="warn" />}
              <span class="figures">{row.entry.levels !== undefined && <b title="number of levels">{shown(row.entry.levels)}</b>}
                {row.entry.softness ? <small title="softness">{shown(row.entry.softness)} %</small> : null}</span>
            </button>
            <Switch name={`Obstacle ${at + 1} is on`} value={row.enabled} onChange={(enabled) => void edit({ do: "enable", row: at, enabled })} />
          </li>
        );
      })}
    </ol>
  );
}

const BLENDS = [
  ["replace", "replace", "This obstacle overwrites the earlier ones."],
  ["max", "max", "Each cell gets the higher level: of this obstacle, or of the earlier ones."],
  ["add", "add", "This obstacle is put on top of the earlier ones."],
  ["min", "min", "Each cell gets the lower level: this obstacle cuts into the earlier ones."],
] as const;

function ObstacleForm({ row }: { row: number }) {
  const { entry } = rowAt(row)!;
  const kind = kindOf(entry.kind);
  const id = useId();
  const at = (name: string) => problemAt(`obstacles[${row}].${name}`);
  const change = (name: string, value: Json | undefined, gesture?: string) => changeEntry(row, name, value, gesture || undefined);
  const turnInto = (name: string) => {
    const next = kindOf(name)!;
    const known = new Set([...next.fields, ...next.place].map((field) => field.name));
    const kept = Object.fromEntries(Object.entries(entry).filter(([key]) => known.has(key)));
    void edit({ do: "change", row, entry: { ...fresh(next), ...kept, kind: name } });
  };
  const own = (kind?.fields ?? []).filter((field) => field.name !== "levels" && field.name !== "softness");
  const levels = kind?.fields.find((field) => field.name === "levels");
  const softness = kind?.fields.find((field) => field.name === "softness");
  return (
    <div class="form obstacle" role="group" aria-label={`Obstacle ${row + 1}`}>
      <Labelled id={`${id}-kind`} label="Type" help={kind?.help} problem={at("kind") || problemAt(`obstacles[${row}]`)}>
        <Select id={`${id}-kind`} value={shown(entry.kind)} onChange={turnInto}
          choices={[...(kind ? [] : [[shown(entry.kind), shown(entry.kind)] as const]), ...hello.value!.kinds.map((each) => [each.name, each.title, each.help] as const)]} />
      </Labelled>
      {levels && <Measure name="levels" label={HEADINGS.levels} unit="levels" help={levels.help} value={entry.levels} range={levels.slider} whole
        note={heights(entry.levels)} problem={at("levels")} onChange={change} />}
      {softness && <Measure name="softness" label={HEADINGS.softness} unit="%" help={softness.help} value={entry.softness ?? 0} range={softness.slider}
        problem={at("softness")} onChange={change} />}
      <Place row={row} />
      <div class="field" data-field="Blend">
        <label title="How it is combined with earlier obstacles">Blend</label>
        <div class="control"><Segmented name="Blend" value={shown(entry.blend ?? "replace")} choices={BLENDS}
          onChange={(value) => change("blend", value === "replace" ? undefined : value)} /></div>
      </div>
      {own.length > 0 && <Form fields={own} values={entry} problems={at} onChange={change} more="More parameters" />}
    </div>
  );
}

/* A number with a slider for its usual values. */
function Measure({ name, label, unit, help, note, problem, range, onChange, ...number }: {
  name: string; label: string; unit?: string; help?: string; note?: string; problem?: string; value: Json | undefined; range: [number, number] | null; whole?: boolean;
  onChange: (name: string, value: Json | undefined, gesture: string) => void;
}) {
  const id = useId();
  const [why, setWhy] = useState("");
  return (
    <Labelled id={id} label={label} unit={unit} help={help} note={note} problem={why || problem} wide>
      <Slider {...number} id={id} name={label} low={range?.[0] ?? 0} high={range?.[1] ?? 100} whole={number.whole ?? false} onWhy={setWhy} problem={problem}
        onChange={(value, gesture) => onChange(name, value, gesture)} />
    </Labelled>
  );
}

const COORDINATES = [["X first", "first", 0], ["Y first", "first", 1], ["X last", "last", 0], ["Y last", "last", 1]] as const;

/* Where the obstacle lies: four coordinates, each of which may be random. */
function Place({ row }: { row: number }) {
  const { entry, ends } = rowAt(row)!;
  const free = isFree(rowAt(row)!);
  const handle = scene.value?.handles?.find((each) => each.row === row);
  const fix = (fixed: boolean) => {
    if (!fixed) void edit({ do: "change", row, entry: Object.fromEntries(Object.entries(entry).filter(([key]) => key !== "first" && key !== "last")) as Entry });
    else if (ends) void edit({ do: "fix", row, index: index.value });
    else void edit({ do: "change", row, entry: { ...entry, first: handle?.first ?? [0, 0], last: handle?.last ?? cells.value.map((count) => count - 1) } });
  };
  const set = (end: "first" | "last", axis: number, value: Json, gesture: string) => {
    const place = pair(entry[end]).map((at, k) => (k === axis ? value : at));
    changeEntry(row, end, place, gesture || undefined);
  };
  return (
    <>
      <div class="field" data-field="Position">
        <label for={`random-${row}`} title={isRandom(rowAt(row)!) ? "On: a new random position on every map. Off: you set its ends" : "Off: you set its ends"}>{isRandom(rowAt(row)!) ? "Random position" : capitalized(usualPlace(rowAt(row)!))}</label>
        <div class="control"><Switch id={`random-${row}`} value={free} onChange={(value) => fix(!value)} /></div>
      </div>
      {!free && (
        <div class="place">
          {COORDINATES.map(([label, end, axis]) => (
            <Coordinate key={label} label={label} value={pair(entry[end])[axis]} high={cells.value[axis]! - 1}
              now={ends?.[end][axis]} problem={problemAt(`obstacles[${row}].${end}`)} onChange={(value, gesture) => set(end, axis, value, gesture)} />
          ))}
        </div>
      )}
    </>
  );
}

function Coordinate({ label, value, high, now, problem, onChange }: {
  label: string; value: Json | undefined; high: number; now?: number; problem: string; onChange: (value: Json, gesture: string) => void;
}) {
  const id = useId();
  const [why, setWhy] = useState("");
  const random = value === "random";
  return (
    <div class="coordinate" data-field={label}>
      <label for={id}>{label}</label>
      <Button icon="dice" class="quiet" title={`${label} is random`} pressed={random} onClick={() => onChange(random ? (now ?? 0) : "random", newGesture())} />
      <Slider id={id} name={label} value={random ? undefined : value} low={0} high={high} whole disabled={random} onWhy={setWhy}
        problem={problem} placeholder={random ? `${now ?? "random"}` : ""} onChange={(next, gesture) => onChange(next!, gesture)} />
      {(why || problem) && <p class="problem" id={`${id}-problem`} role="alert">{why || problem}</p>}
    </div>
  );
}
