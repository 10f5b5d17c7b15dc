/* What the page and its server say to each other. Lengths are in metres, angles in radians, unless a name ends in _cm.

   POST /api/NAME, "Authorization: Bearer TOKEN", JSON object of arguments --> 200 and JSON, or 4xx and {error: Failure}
   A call of a document has `doc`, its id, among its arguments.
   POST /api/events {doc, page}  --> a stream of lines, each an Event as JSON, open as long as the page is
   POST /api/upload?name=N, bytes --> {path}, for scan, compare and import
   POST /api/file {path}         --> the bytes of a file under the server's folder: pictures, tables, PDF
*/

export type Json = null | boolean | number | bigint | string | Json[] | { [key: string]: Json };
/* Integers that a number of JavaScript would round, such as seeds, are bigint here, and plain integers on the wire. */
export type Cell = [number, number]; // of blocks, frames not counted: x, y
export type Entry = { kind: string; [parameter: string]: Json }; // an obstacle as a recipe file has it

export interface Failure { where: string; text: string; kind?: "exists" | "changed" }
/* where: the parameter, as in obstacles[2].softness; kind: a question instead of an error: repeat with replace: true */

/* ---- what is the same for all documents: hello {} --> Hello */

export interface Hello {
  version: string;
  folder: string; // in which files may be read and written
  globals: Group[]; // the parameters of a map, in groups as the help has them
  kinds: Kind[]; // kinds of obstacles
  examples: { name: string; description: string }[];
  robots: { name: string; title: string }[];
  commands: Command[]; // what may be run
  formats: { name: string; description: string }[];
  metrics: { name: string; title: string }[]; // by which maps can be sorted
}

/* A parameter in a form: a JSON Schema property with what a form needs besides. */
export interface Field {
  name: string;
  title: string; // a word or two
  help: string;
  schema: Schema;
  unit: string; // "cm", "%", "units", "s", ""
  default: Json; // null: none, or decided by the program
  basic: boolean; // shown at once; others under "More"
  flag?: string; // of a command
  required?: boolean; // of a command: it does not run without
}
export interface Schema {
  type?: "integer" | "number" | "string" | "boolean" | "array";
  enum?: string[]; minimum?: number; maximum?: number; pattern?: string;
  anyOf?: Schema[]; items?: Schema; prefixItems?: Schema[]; minItems?: number; maxItems?: number;
}
export interface Group { title: string; fields: Field[] }
export interface Kind { name: string; title: string; help: string; default_place: string; fields: Field[]; place: Field[] }
/* default_place: where it lies without ends; fields: its own, levels and softness first; place: first, last, blend, key */
export interface Command {
  name: string; help: string; group: string; target: "recipe" | "none"; fields: Field[];
  output: "folder" | "file" | "none"; output_help: string; output_required: boolean;
}

/* ---- documents: open {what} --> {doc}; what: "" new, a path, the name of an example, DIR#17 */

export interface State {
  doc: string;
  revision: number; // counts changes, undo included
  title: string;
  path: string | null;
  unsaved: boolean;
  can_undo: boolean;
  can_redo: boolean;
  values: { [parameter: string]: Json }; // global parameters
  rows: Row[];
  problem: { where: string; text: string } | null; // the draft is invalid; the scene is of the last valid one
  maps: number;
  first_map: number;
  name: string;
  changed_on_disk: boolean; // somebody else wrote the file
  recovered: string | null; // changes of a session that ended without saving were brought back: when
  journal?: string; // why changes would be lost in a crash, such as a full disk; empty: they would not
  pages: number; // that have it open
}
export interface Row {
  entry: Entry;
  enabled: boolean;
  ends: { first: Cell; last: Cell } | null; // where it lies in the map shown, also if drawn at random
}

/* state {doc, page?, index?} --> State; page: a name that a page gives itself; index: the map that it shows */
/* edit {doc, actions, index?} --> State & {selected: number}; actions of one gesture (any string) are undone together */
export type Action =
  | { do: "set"; name: string; value: Json; gesture?: string }
  | { do: "reroll" }
  | { do: "add"; entry: Entry; at?: number }
  | { do: "change"; row: number; entry: Entry; gesture?: string }
  | { do: "remove"; row: number }
  | { do: "clear" }
  | { do: "move"; row: number; to: number }
  | { do: "enable"; row: number; enabled: boolean }
  | { do: "duplicate"; row: number }
  | { do: "fix"; row: number; index: number } // random ends become the cells where they are in this map
  | { do: "move_end"; row: number; end: "first" | "last" | "both"; cell: Cell; gesture?: string }
  | { do: "paint"; row: number; cells: Cell[]; level: number; gesture?: string } // -1: erase; row -1: a new matrix
  | { do: "undo" } | { do: "redo" };
/* save {doc, path?, replace?} --> State;  reload {doc} --> State (from the file);  close {doc} */
/* texts {doc} --> {recipe, python, shell}: the document as YAML, as Python, as a command line */
/* files {folder?} --> {folder, entries: {name, path, kind: "recipe"|"folder"|"dataset"|"drive"|"other"}[]} */

/* ---- what is drawn: scene {doc, index?} --> SceneData; a frozen page has it too, without what only an editor needs */

/* ghost {doc, entry, index?} --> SceneData with one more obstacle, the last row: what would be if it were added */

export interface SceneData {
  name: string;
  description: string;
  cells: [number, number]; // of the field, frames included
  block_width: number;
  block: string; // the same in words: "10 cm"
  unit: string; // of labels: "cm"
  palette: Material[];
  bytes: 1 | 2; // of each number of content
  content: string; // base64: of each cell the number of its material, all of the first i (x) first; little endian
  facts: [string, string][];
  metrics: [string, string, string][]; // name, value, meaning
  recipe: string;
  file: string;
  look: "plain" | "wood" | string;
  step: number; // metres of a unit
  // of documents alone
  revision?: number;
  index?: number;
  factor?: number; // a cell here is the highest of factor x factor cells of a large map; 1: the cell itself
  owners?: string; // base64 of int16 for each cell, as content: the row of the obstacle that made its level; -1: none
  handles?: { row: number; first: Cell | null; last: Cell | null }[];
  warnings?: string[];
  cost?: string; // "1 model, 1,024 faces, 34 kB"
  constraints?: string[]; // lines of the constraint report
}
export interface Material {
  level: number | null; // null: a frame
  height: number;
  label: string; // the height in `unit`
  colour: string; // "#rrggbb" on the plan and in the height look
  surface: string; // in the look of the recipe
  count: number;
}

/* variants {doc, count} --> Variant[];  maps {doc, first, count, by?} --> Variant[] (of the recipe's own maps, from the
   place first on; by: sorted by a metric, the first of its difficulty) */
export interface Variant { seed: number; index: number; scene: SceneData; difficulty: [string, string][] }

/* measure {doc, index, robot?} --> {rows: [name, value, meaning, key][]}: all metrics, also those of a robot */

/* ---- robots */

/* robot {robot} --> RobotDrawing */
export interface RobotDrawing {
  name: string; title: string; size: [number, number, number];
  lift: number; // of the origin of its model in a simulator, above the origin of these parts
  parts: { shape: "box" | "cylinder" | "sphere"; size: number[]; pose: number[]; colour: string; wheel: boolean }[];
  /* size: box x y z; cylinder radius, length along z; sphere radius. pose: 4x4, row by row, in the robot's frame */
}
/* pose {doc, index, robot, x, y, heading} --> Pose; of a robot that does not stand: level, where it was put */
export interface Pose {
  stands: boolean; holds: boolean; pushes: boolean;
  reason: string; // "" or why it is bad: "tips over", "slips", "cannot drive on", "hangs up"
  x: number; y: number; z: number; roll: number; pitch: number; yaw: number;
  tilt: number; margin: number; // angle to tip over
  clearance: number | null;
  centre: [number, number, number]; // of mass
  contacts: [number, number, number][];
  polygon: [number, number, number][]; // support polygon, in order
}
/* tilt {doc, index, robot, heading} --> PoseMap: on a regular grid of nx x ny points, x first */
export interface PoseMap {
  shape: [number, number]; low: [number, number]; step: number; // of points, metres
  tilt: string; margin: string; // base64 of float32, NaN where it does not stand
  reason: string; // base64 of uint8, an index into reasons
  reasons: string[];
}
/* reach {doc, index, robot} --> Reach */
export interface Reach {
  text: string; // "crosses west to east"
  region: string; // base64 of uint8 for each cell: 1 where it gets
  ways: { points: [number, number, number][]; name: string; crosses: boolean }[]; // laid on the blocks
  spots: { x: number; y: number; z: number; yaw: number; name: "S" | "G" }[];
}
/* way {doc, index, robot, start, goal, best} --> Way; start, goal: [x, y] */
/* stop {doc, of}: end a search that is under way; its call fails */
export type Search = "tilt" | "reach" | "way";
export interface Way {
  found: boolean; text: string;
  poses: [number, number, number, number, number, number][]; // x y z roll pitch yaw of the robot's origin
  events: { at: number; text: string }[]; // drops, slips: the number of the pose
  length: number; worst_tilt: number; least_margin: number;
}

/* ---- commands: run {doc, command, values, output?, replace?} --> Job; cancel {job} --> Job; jobs {} --> Job[] */

export interface Job {
  id: number;
  doc: string;
  command: string;
  line: string; // the same in a shell: "rsegen drive my.yaml --robot burger -o drives"
  state: "running" | "done" | "failed" | "cancelled";
  done: number | null; total: number | null; step: string; // progress; total null: unknown
  lines: string[]; // its report, or the one line of its error
  files: { path: string; name: string; kind: "picture" | "table" | "pdf" | "recipe" | "dataset" | "page" | "drive" }[];
  result: Json; // of --json
  opens?: string; // a recipe that a page may open: of scan, import
}

/* playback {path} --> Playback: a drive that was recorded, path a folder of rsegen drive */
export interface Playback {
  title: string; simulator: string;
  robots: { name: string; robot: string; seconds: number[]; poses: number[][]; // x y z roll pitch yaw
            events: { second: number; text: string; kind: "contact" | "trouble" | "success" }[] }[]; // in order of time
  duration: number;
}

/* ---- events of a document */
export type Event =
  | { event: "state"; state: State; page: string } // page: that changed it
  | { event: "job"; job: Job }
  | { event: "file"; changed_on_disk: boolean }
  | { event: "progress"; of: Search; share: number } // of a search of a robot, 0 to 1
  | { event: "alive" };
