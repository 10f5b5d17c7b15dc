/* All that the page knows, as signals, and the door through which it changes the document.

   A change is shown at once, and sent: changes wait while an earlier one is under way, and those of one gesture become one.
   What the server answers holds, unless it is older than what is known already. */

import { computed, effect, signal } from "@preact/signals";
import { Failed, SILENT, call, listen } from "./server";
import type {
  Action, Calls, Entry, Event, Failure, Frozen, Hello, Job, Json, MapResults, Playback, DrawnPose, PoseMap, DrawnCrossing, DrawnReach, Row, RobotShapes, SceneData, State, DrawnWay,
} from "./protocol";
import type { Hover, Options, Tool } from "./views";

const data = document.getElementById("data");
export const frozen: Frozen | null = data && (JSON.parse(data.textContent!) as Frozen);

export const hello = signal<Hello | null>(null);
export const state = signal<State | null>(null);
export const scene = signal<SceneData | null>(null);
export const ghost = signal<{ scene: SceneData; row: number } | null>(null); // an obstacle that is not added yet
export const index = signal(0); // of the map that is shown
export const selected = signal(-1);
export const tool = signal<Tool>({ name: "select" });
export const drawnKind = signal("diagonal_barrier"); // of the obstacles that the tool draw makes
export const hover = signal<Hover | null>(null);
export const busy = signal(0); // calls under way that somebody waits for
export const problem = signal<Failure | null>(null); // of the last call that failed
export const said = signal(""); // what has been done, for the live region
export const lost = signal(""); // why the page hears nothing of its document; empty: it does
export const jobs = signal<Job[]>([]);
export const options = signal<Partial<Options>>({ look: "recipe", grid: true, axes: true });
export const plan = signal<"inset" | "half" | "hidden">("inset");
export const tab = signal<"obstacles" | "map" | "robot" | "results">("map");
export const dialog = signal<
  { name: "open" | "save" | "help" | "variants" } | { name: "run"; command: string; upload?: string; target?: string } | { name: "jobs" } | null
>(null);

export const robot = signal(""); // its name; empty: none
export const drawing = signal<RobotShapes | null>(null);
export const heading = signal(0);
export const put = signal<[number, number] | null>(null); // where it was put: tilted, its origin is a little aside
export const stays = signal(false); // it was put there by a click or a key, and does not follow the mouse any more
export const drawings = signal<Map<string, RobotShapes>>(new Map()); // by names of kinds, and by those that models have in files
export const pose = signal<DrawnPose | null>(null);
export const poseMap = signal<PoseMap | null>(null);
export const mapShown = signal<"tilt" | "margin" | "reason">("tilt");
export const reach = signal<DrawnReach | null>(null);
export const crossing = signal<DrawnCrossing | null>(null); // a prediction
export const wayStart = signal<[number, number] | null>(null);
export const way = signal<DrawnWay | null>(null);
export type Searched = "tilt" | "reach" | "crossing" | "way";
export const searching = signal<{ of: Searched; step: string; share: number } | null>(null); // of the robot on the map
export const playbacks = signal<Playback[]>([]); // none, one, or two side by side
export const played = signal(""); // the folder of the drive that is played, for the address
export const second = signal(0);

const size = signal<[number, number]>([innerWidth, innerHeight]);
addEventListener("resize", () => (size.value = [innerWidth, innerHeight]));
/* A phone that lies on its side, and a small screen at 200 %, have room beside the map, not below it. */
export const layout = computed(() => {
  const [width, height] = size.value;
  return width < 760 && !(width > 560 && height < 480) ? "phone" : width < 1180 ? "narrow" : "wide";
});
/* Whether the plan in a corner would lie over the drive that is played. */
export const isCramped = computed(() => size.value[0] < 760 || size.value[1] < 480);
const darkness = matchMedia("(prefers-color-scheme: dark)");
export const dark = signal(darkness.matches);
darkness.addEventListener("change", () => (dark.value = darkness.matches));

/* Cells of the map along x and y, frames left out, in which obstacles are placed. */
export const cells = computed<[number, number]>(() => {
  const { chunk_size: side, chunks } = state.value?.values ?? {};
  const [x, y] = Array.isArray(chunks) ? chunks : [chunks, chunks];
  return [Number(side ?? 10) * Number(x ?? 1), Number(side ?? 10) * Number(y ?? 1)];
});

/* Say what has been done, for some seconds. */
export function say(text: string): void {
  said.value = text;
  setTimeout(() => (said.value = said.value === text ? "" : said.value), 4000);
}

/* Do something that may fail; what it fails with is shown, until something else that the user asked for succeeds. */
export async function attempt<T>(work: () => Promise<T>, asked = true): Promise<T | null> {
  busy.value++;
  try {
    const result = await work();
    if (asked) problem.value = null;
    return result;
  } catch (error) {
    if (!(error instanceof Failed)) throw error;
    problem.value = error.failure;
    return null;
  } finally {
    busy.value--;
  }
}

/* Return a function that does the work, once more if it was called meanwhile, never twice at a time. */
export function newest<A extends unknown[]>(work: (...args: A) => Promise<unknown>): (...args: A) => void {
  let next: A | null = null;
  let runs = false;
  return async (...args) => {
    next = args;
    if (runs) return;
    runs = true;
    while (next) {
      const now: A = next;
      next = null;
      await attempt(() => work(...now), false);
    }
    runs = false;
  };
}

/* List a job that was started; an event may have told of it already, and then knows more. */
export function list(job: Job): void {
  if (!jobs.value.some((each) => each.id === job.id)) jobs.value = [job, ...jobs.value];
}

/* ---- the document */

const page = Math.random().toString(36).slice(2);
let ends = new AbortController();

export const doc = () => state.value?.doc ?? "";

/* Call a function of the server about the document. */
export const ask = <N extends keyof Calls>(name: N, args: Own<N>): Promise<Calls[N]["result"]> =>
  call(name, { doc: doc(), page, ...args } as Calls[N]["args"]);
type Own<N extends keyof Calls> = Omit<Calls[N]["args"], "doc" | "page">;

const shownIndex = () => ({ index: index.value });

const draw = newest(async () => {
  const wanted = doc();
  const drawn = await ask("scene", shownIndex());
  if (wanted === doc() && (drawn.revision ?? 0) >= (scene.value?.revision ?? 0)) scene.value = drawn;
});

/* The name of a map as it is drawn: of its document, its changes, and its place among the maps. */
export const nameOf = (map: SceneData) => `${doc()} ${map.revision} ${map.index}`;

/* What is measured of a map, and what it costs: asked for by the panel that shows it; of: the name of the map. */
export const results = signal<(MapResults & { of: string }) | null>(null);

export const measure = newest(async () => {
  const map = scene.value;
  if (!map) return;
  const wanted = nameOf(map);
  try {
    const found = await ask("results", { index: map.index ?? null });
    if (wanted.startsWith(`${doc()} `)) results.value = { ...found, of: wanted };
  } catch (error) {
    results.value = null; // and not those of another map
    throw error;
  }
});

/* Show an obstacle on the map before it is added; null: none. */
export const showGhost = newest(async (entry: Entry | null) => {
  const shown = entry && (await ask("ghost", { entry, ...shownIndex() }).catch(() => null)); // a draft may be invalid
  ghost.value = shown && { scene: shown, row: state.value!.rows.length };
});

let held: State | null = null; // the newest state of the server, without changes that it has not answered yet

/* Take over a state of the document, unless it is older than the one that is known: then only what was answered goes. */
export function take(given: State): void {
  const known = state.value;
  if (known && given.doc !== known.doc) return;
  const next = known && held && given.revision < held.revision ? held : given;
  selected.value = followed(selected.value, held?.doc === next.doc ? held.rows : [], next.rows);
  held = next;
  state.value = [...flying, ...waiting].reduce(ahead, next);
  selected.value = Math.min(selected.value, next.rows.length - 1);
  const first = next.first_map ?? 0;
  const stays = index.value >= first && index.value < first + next.maps;
  if (!stays) index.value = first;
  if (!known || next.revision > known.revision || !stays) draw();
}

/* The row of an obstacle after others were added, moved or removed by undo, or on another page: found by its key. */
function followed(row: number, before: Row[], after: Row[]): number {
  const key = before[row]?.entry.key;
  if (key === undefined || after[row]?.entry.key === key) return row;
  const at = after.findIndex((each) => each.entry.key === key);
  return at < 0 ? row : at;
}

/* Show another of the maps of the recipe. */
export async function showMap(number: number): Promise<void> {
  index.value = number;
  draw();
  const next = await attempt(() => ask("state", { index: number }));
  if (next) take(next); // the ends of obstacles that are drawn at random
}

/* Edit another document: a new one, a file, an example, a map of a data set, that of a drive; null if it cannot be had. */
export async function open(what: string): Promise<Calls["open"]["result"] | null> {
  const left = doc();
  const opened = await attempt(() => call("open", { what }));
  if (opened === null || !(await load(opened.doc))) return null;
  if (left && left !== opened.doc) await attempt(() => call("close", { doc: left }), false); // else its changes would come back
  return opened;
}

async function load(id: string): Promise<boolean> {
  const next = await attempt(() => call("state", { doc: id, page }));
  if (!next) return false;
  ends.abort();
  ends = new AbortController();
  waiting = [];
  state.value = scene.value = results.value = null;
  selected.value = -1;
  index.value = next.first_map ?? 0;
  forgetRobot();
  take(next);
  void listen(id, page, hear, (why) => void lose(id, why), ends.signal);
  return true;
}

let soughtFor = ""; // the document that was opened anew, as its server had gone

/* Note why the page hears nothing of a document. If the server answers, but does not know it, as it was started anew, it is
   opened again, once. */
async function lose(id: string, why: string): Promise<void> {
  lost.value = why;
  if (!why || why === SILENT || soughtFor === id) return;
  soughtFor = id;
  const asked = new URLSearchParams(location.search);
  const opened = await attempt(() => call("open", { what: asked.get("open") ?? "" }));
  if (!opened || id !== doc() || !(await load(opened.doc))) return;
  await listJobs(); // those of the server before have ended
  await restore(asked);
}

async function listJobs(): Promise<void> {
  jobs.value = (await call("jobs", {}).catch(() => null)) ?? [];
}

/* The address of the page opens the document that it shows, this one as long as its server runs, later its file, with
   the map, the panel and the robot that are chosen. */
effect(() => {
  const now = state.value;
  if (!now) return;
  const asked = new URLSearchParams({ token: new URLSearchParams(location.search).get("token") ?? "" });
  const shown = {
    open: now.opens, doc: now.doc, map: index.value === (now.first_map ?? 0) ? "" : String(index.value),
    panel: tab.value === "map" ? "" : tab.value, robot: robot.value, play: playbacks.value.length ? played.value : "",
  };
  for (const [key, value] of Object.entries(shown)) if (value) asked.set(key, value);
  history.replaceState(null, "", `?${asked}`);
});

/* Choose what the address names besides the document. */
async function restore(asked: URLSearchParams): Promise<void> {
  const [now, map, panel, name] = [state.value!, Number(asked.get("map")), asked.get("panel"), asked.get("robot")];
  const first = now.first_map ?? 0;
  if (map > first && map < first + now.maps) await showMap(map);
  if (panel === "obstacles" || panel === "robot" || panel === "results") tab.value = panel;
  if (name) await chooseRobot(name); // else one that was chosen meanwhile stays
}

function hear(event: Event): void {
  if (event.event === "state") take(event.state);
  if (event.event === "job") jobs.value = [event.job, ...jobs.value.filter((job) => job.id !== event.job.id)];
  if (event.event === "progress" && searching.value?.of === event.of) searching.value = { ...searching.value, step: event.step, share: event.share };
  if (event.event === "file" && held) take({ ...held, changed_on_disk: event.changed_on_disk });
}

/* ---- changes */

let waiting: Action[] = [];
let flying: Action[] = []; // sent, and not answered yet: an event of an earlier change does not take them back
let sends: Promise<void> | null = null;

/* Change the document. */
export function edit(...actions: Action[]): Promise<void> {
  for (const action of actions) {
    const last = waiting.at(-1);
    if (last && isSameGesture(last, action)) waiting[waiting.length - 1] = joined(last, action);
    else waiting.push(action);
    if (state.value) state.value = ahead(state.value, action);
  }
  return (sends ??= send().finally(() => (sends = null)));
}

async function send(): Promise<void> {
  while (waiting.length) {
    // Paint that makes a matrix is answered before what comes after it, which belongs into that matrix too.
    const makes = waiting.findIndex((action) => action.do === "paint" && intoItsMatrix(action).row < 0);
    const actions = waiting.splice(0, makes < 0 ? waiting.length : makes + 1).map(intoItsMatrix);
    flying = actions;
    const next = await attempt(() => ask("edit", { actions, ...shownIndex() }));
    flying = [];
    if (next) {
      take(next);
      actions.forEach((action) => (selected.value = selectedAfter(action, next.rows.length)));
    } else {
      const failure = problem.value;
      const now = await attempt(() => ask("state", {}), false);
      if (now) take({ ...now, problem: now.problem ?? failure });
      else takeBack();
    }
  }
}

/* Show the document without changes that the server cannot be told of. */
function takeBack(): void {
  waiting = [];
  if (held) take(held);
}

/* Paint for a new matrix, in the one that is selected meanwhile, as earlier paint has made it. */
function intoItsMatrix<A extends Action>(action: A): A {
  const isMade = action.do === "paint" && action.row < 0 && rowAt(selected.value)?.entry.kind === "matrix";
  return isMade ? { ...action, row: selected.value } : action;
}

function isSameGesture(one: Action, other: Action): boolean {
  if (one.do !== other.do || !("gesture" in one && one.gesture) || !("gesture" in other)) return false;
  if (one.do === "paint" && other.do === "paint" && (one.level !== other.level || one.row !== other.row)) return false;
  return one.gesture === other.gesture && (one.do !== "set" || (other.do === "set" && one.name === other.name));
}

/* The later of two changes of one gesture; strokes of paint add up. */
function joined(one: Action, other: Action): Action {
  return one.do === "paint" && other.do === "paint" ? { ...other, cells: [...one.cells, ...other.cells] } : other;
}

/* The state as it will be: what a form shows, and what the next change of the same obstacle is based on. */
function ahead(now: State, action: Action): State {
  const change = (row: number, to: Partial<Row>) => ({
    ...now, rows: now.rows.map((each, at) => (at === row ? { ...each, ...to } : each)),
  });
  if (action.do === "set") return { ...now, values: { ...now.values, [action.name]: action.value } };
  if (action.do === "change") return change(action.row, { entry: action.entry });
  if (action.do === "enable") return change(action.row, { enabled: action.enabled });
  return now;
}

function selectedAfter(action: Action, rows: number): number {
  switch (action.do) {
    case "add": return action.at ?? rows - 1;
    case "duplicate": return action.row + 1;
    case "move": return action.to;
    case "remove": return Math.min(action.row, rows - 1);
    case "clear": return -1;
    case "paint": return action.row < 0 ? rows - 1 : action.row;
    default: return Math.min(selected.value, rows - 1);
  }
}

let gestures = 0;
export const newGesture = () => `${page}-${++gestures}`;

/* The problem of a parameter, such as unit_cm or obstacles[2].softness. */
export function problemAt(where: string): string {
  const found = [state.value?.problem, problem.value].find((each) => each && each.where === where);
  return found?.text ?? "";
}

/* What parameters of an obstacle are called in its form. */
export const HEADINGS = { levels: "Height", softness: "Softness" };

/* A problem in the words of the page: of obstacles[2].levels, "Obstacle 3, Height". */
export function told({ where, text }: Failure): string {
  const [, row, name] = /^obstacles\[(\d+)\](?:\.(\w+))?/.exec(where) ?? [];
  const kind = hello.value?.kinds.find((each) => each.name === rowAt(Number(row))?.entry.kind);
  const fields = row === undefined ? (hello.value?.globals.flatMap((group) => group.fields) ?? []) : [...(kind?.fields ?? []), ...(kind?.place ?? [])];
  const title = HEADINGS[name as keyof typeof HEADINGS] ?? fields.find((field) => field.name === (name ?? where))?.title ?? name ?? where;
  const place = row === undefined ? title : `Obstacle ${Number(row) + 1}${name ? `, ${title}` : ""}`;
  return place ? `${place}: ${text}` : text;
}

/* A warning, in which obstacles are counted from 0 as in files, as the list on the page counts them. */
export function counted(text: string): string {
  return text.replace(/\bobstacles\[(\d+)\]/g, (_, row: string) => `obstacle ${Number(row) + 1}`);
}

export const rowAt = (row: number): Row | undefined => state.value?.rows[row];

/* The parameters that have a number for each level, for another number of levels: new levels are as likely as the last,
   and none of their blocks are counted. */
function fitted({ weights, counts }: Entry, levels: number): Partial<Entry> {
  const to = (list: Json[], filling: Json) => Array.from({ length: levels }, (_, level) => list[level] ?? filling);
  return {
    ...(Array.isArray(weights) && weights.length && { weights: to(weights, weights.at(-1)!) }),
    ...(Array.isArray(counts) && counts.length && { counts: to(counts, 0) }),
  };
}

export function changeEntry(row: number, name: string, value: Json | undefined, gesture?: string): void {
  const entry: Entry = { ...rowAt(row)!.entry };
  if (value === undefined || value === null) delete entry[name];
  else entry[name] = value;
  if (name === "levels" && typeof value === "number") Object.assign(entry, fitted(entry, value));
  void edit({ do: "change", row, entry, gesture });
}

/* ---- files */

/* The first field whose text cannot be read, as what a run, or saving, fails with: the value that stands for it is an earlier one. */
export function unreadIn(part: ParentNode): Failure | null {
  const input = part.querySelector<HTMLInputElement>("input:invalid");
  if (!input) return null;
  input.closest("details")?.setAttribute("open", "");
  input.focus();
  return { where: input.closest<HTMLElement>("[data-field]")?.dataset.field ?? "", text: input.validationMessage };
}

export async function save(path?: string, replace = false): Promise<boolean> {
  await sends;
  const unread = unreadIn(document);
  if (unread) return (problem.value = unread), false;
  if (!path && !state.value?.path) return (dialog.value = { name: "save" }), false;
  const next = await attempt(() => ask("save", { ...(path && { path }), ...(replace && { replace }) }));
  if (!next) return false;
  take(next);
  say(`Saved as ${next.title}`);
  return true;
}

export async function reload(): Promise<void> {
  const next = await attempt(() => ask("reload", {}));
  if (next) take(next);
}

/* ---- the robot */

export function forgetRobot(): void {
  stopSearch();
  pose.value = poseMap.value = reach.value = crossing.value = way.value = wayStart.value = put.value = null;
  stays.value = false;
}

export async function chooseRobot(name: string): Promise<void> {
  robot.value = name;
  drawing.value = null;
  forgetRobot();
  if (!name) return;
  const shapes = await attempt(() => call("robot", { robot: name }));
  if (robot.value !== name) return; // another one was chosen meanwhile
  if (!shapes) return void (robot.value = "");
  drawing.value = shapes;
  drawings.value = new Map([...drawings.value, [name, shapes], ...(isOfFile(name) ? [[shapes.title, shapes] as const] : [])]);
  tool.value = { name: "robot", heading: heading.value };
}

/* Whether a robot is a file: its model has another name, by which drives know it. */
const isOfFile = (name: string) => /[./]/.test(name);

const ofRobot = () => ({ index: index.value, robot: robot.value });

export const settle = newest(async (x: number, y: number) => {
  if (!robot.value) return;
  const wanted: [number, number] = [x, y];
  put.value = wanted;
  const found = await ask("pose", { ...ofRobot(), x, y, heading: heading.value });
  if (put.value === wanted) pose.value = found; // the map, or the robot, may be another one meanwhile
});

/* Turn the robot where it is. */
export function face(angle: number): void {
  heading.value = Math.atan2(Math.sin(angle), Math.cos(angle));
  if (tool.value.name === "robot") tool.value = { name: "robot", heading: heading.value };
  if (put.value) settle(...put.value);
}

let searches = 0;

/* Search the map with the robot. A newer search takes the place of one that is under way, whose answer is null. */
async function search<N extends Searched>(
  of: N, args: Omit<Own<N>, "index" | "robot">,
): Promise<Calls[N]["result"] | null> {
  if (searching.value?.of !== of) stopSearch(); // one of its own sort is stopped by the server
  const own = ++searches;
  searching.value = { of, step: "", share: 0 };
  try {
    const found = await ask(of, { ...ofRobot(), ...args } as Own<N>);
    return own === searches ? found : null;
  } catch (error) {
    if (!(error instanceof Failed)) throw error;
    if (own === searches) problem.value = error.failure;
    return null;
  } finally {
    if (own === searches) searching.value = null;
  }
}

export function stopSearch(): void {
  const now = searching.peek();
  if (!now) return;
  searches++;
  searching.value = null;
  void attempt(() => ask("stop", { of: now.of }), false);
}

export async function showTilt(): Promise<void> {
  poseMap.value = (await search("tilt", { heading: heading.value })) ?? poseMap.value;
}

export async function showReach(): Promise<void> {
  reach.value = (await search("reach", {})) ?? reach.value;
}

/* Predict whether it gets across, by many drives. */
export async function showCrossing(): Promise<void> {
  crossing.value = (await search("crossing", {})) ?? crossing.value;
}

export async function wayPoint(x: number, y: number, best: Calls["way"]["args"]["best"]): Promise<void> {
  if (!wayStart.value || way.value) {
    way.value = null;
    wayStart.value = [x, y];
  } else {
    way.value = await search("way", { start: wayStart.value, goal: [x, y], best });
  }
}

/* What is known of a robot on a map does not hold for another map. */
let drawnFor = "";
effect(() => {
  const drawn = scene.value ? nameOf(scene.value) : "";
  if (drawn !== drawnFor) forgetRobot();
  drawnFor = drawn;
});

/* ---- the start */

/* Open what the address names, or a new recipe. */
export async function start(): Promise<void> {
  if (frozen) return void (scene.value = frozen.maps[0] ?? null);
  const asked = new URLSearchParams(location.search);
  const [known, list] = [asked.get("doc"), attempt(() => call("hello", {}))];
  const loads = (known && (await load(known))) || (await open(asked.get("open") ?? ""));
  const failure = loads ? null : problem.value;
  hello.value = await list;
  if (!loads && hello.value) await open(""); // a page without a recipe could do nothing
  if (hello.value) await listJobs();
  problem.value = hello.value ? failure : problem.value;
  if (loads) await restore(asked);
}

addEventListener("beforeunload", (event) => {
  if (state.value?.unsaved) event.preventDefault();
});
