/* What the page and its server say to each other. Made by `python -m docs.protocol` of the types in Python.

   POST /api/NAME, "Authorization: Bearer TOKEN", JSON object of arguments --> 200 and JSON, or 4xx and {error: Failure}
   POST /api/events {doc, page}  --> a stream of lines, each an Event as JSON, open as long as the page is
   POST /api/upload?name=N, bytes --> {path}, for scan, compare and import
   POST /api/file {path}         --> the bytes of a file under the server's folder: pictures, tables, PDF

   Lengths are in metres, angles in radians, unless a name ends in _cm. Every call may have `page`, the name that a page
   gives itself, and `doc`. Actions of one gesture, any text, are undone together. */

/* Integers that a number of JavaScript would round, such as seeds, are bigint here, and plain integers on the wire. */
export type Json = null | boolean | number | bigint | string | Json[] | { [key: string]: Json };
export type Entry = { kind: string; [parameter: string]: Json }; // an obstacle as a recipe file has it
export type Cell = [number, number]; // of blocks, frames not counted: x, y
export type SceneData = Drawing & Partial<MapData & DocumentMap>; // a map of a document, or of a page that is a file

/* A command that waits, runs, or has ended. */
export interface Job {
  id: number;
  doc: string;
  command: string;
  line: string; // the same in a shell: "rsegen drive my.yaml --robot burger -o drives"
  state: "running" | "done" | "failed" | "cancelled";
  done: number | null;
  total: number | null; // null: unknown
  step: string;
  lines: string[]; // its report, or the one line of its error
  output: string; // the file or folder that it writes, seen from the folder of pages
  files: MadeFile[];
  result: Json; // of --json
  opens: string | null; // a recipe that a page may open: of scan, import
}

/* A file that a command wrote. */
export interface MadeFile {
  path: string;
  name: string;
  kind: "picture" | "table" | "pdf" | "recipe" | "dataset" | "page" | "drive";
}

/* A prediction of whether a robot gets across a map, with its drives. */
export interface DrawnCrossing {
  text: string; // why nothing is predicted, else empty
  simulator: string; // with the model of motors
  sides: CrossingOfSide[];
  ways: Across[]; // of each drive: it crosses, or ends where the robot stayed
}

/* A prediction of whether a robot gets from one side of a map to the other. */
export interface CrossingOfSide {
  name: string; // "west to east"
  probability: number;
  crossed: number;
  drives: number;
  seconds: number | null; // until it is across, in the middle; null: no drive crosses
  ends: DrawnEnd[]; // the most frequent first
}

/* A place where drives that do not cross end. */
export interface DrawnEnd {
  reason: string; // in words that follow "the robot"
  x: number;
  y: number;
  drives: number;
}

/* A way across a map, laid on the blocks. */
export interface Across {
  points: [number, number, number][];
  name: string;
  crosses: boolean;
}

/* The state after a change. */
export interface EditedState {
  doc: string;
  opens: string; // by what it is opened again after a restart; empty: a new recipe
  revision: number; // counts changes, undo included
  title: string;
  path: string | null;
  unsaved: boolean;
  can_undo: boolean;
  can_redo: boolean;
  values: { [name: string]: Json }; // global parameters
  rows: Row[];
  problem: Problem | null;
  maps: number;
  first_map: number;
  data_set: PlaceInDataSet | null; // that the recipe is the map of
  name: string;
  changed_on_disk: boolean; // somebody else wrote the file
  file_is_gone: boolean; // somebody else removed or renamed it
  recovered: string | null; // changes of a session that ended without saving were brought back: when
  journal: string; // why changes would be lost in a crash, such as a full disk; empty: they would not
  pages: number; // that have it open
  selected: number; // the row that the last action was about; -1: none
}

/* An obstacle in the list of a document. */
export interface Row {
  entry: Entry; // without whether it is switched on
  enabled: boolean;
  ends: Ends | null; // where it lies in the map shown, also if drawn at random
}

/* The two ends of an obstacle, each a list in a file. */
export interface Ends {
  first: [number, number];
  last: [number, number];
}

/* The reason why a draft is invalid; the scene shows the last valid one. */
export interface Problem {
  where: string;
  text: string;
}

/* The place of a map in a data set. */
export interface PlaceInDataSet {
  folder: string;
  place: number; // from 0 on, as in DIR#17
  maps: number;
}

/* A map as it is drawn, without its metrics. */
export interface Drawing {
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
  recipe: string;
  file: string;
  look: string;
  step: number; // metres of a unit
}

/* A material of cells: a level of blocks, or the frames. */
export interface Material {
  level: number | null; // null: a frame
  height: number;
  label: string; // the height in `unit`
  colour: string; // "#rrggbb" on the plan and in the height look
  surface: string; // in the look of the recipe: the same, but for wood and friction
  count: number;
}

/* The content of a folder. */
export interface Listing {
  folder: string;
  entries: ListedFile[];
}

/* A file or folder, as a list of files has it. */
export interface ListedFile {
  name: string;
  path: string;
  kind: "recipe" | "folder" | "dataset" | "drive" | "other";
}

/* A map of a document as it is drawn, with what only an editor needs. */
export interface DocumentMap {
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
  recipe: string;
  file: string;
  look: string;
  step: number; // metres of a unit
  factor: number; // a cell here is the highest of factor x factor cells of a large map; 1: the cell itself
  warnings: string[];
  revision: number;
  index: number;
  owners: string; // base64 of int16 for each cell, as content: the row of the obstacle that made its level; -1: none
  handles: Handle[];
}

/* Place of the obstacle of a row. */
export interface Handle {
  first: [number, number];
  last: [number, number];
  row: number;
}

/* Data that are the same for all documents. */
export interface Hello {
  version: string;
  folder: string; // in which files may be read and written
  read_only: string; // why nothing can be saved in it; empty: it can
  globals: Group[]; // the parameters of a map
  kinds: Kind[];
  examples: Described[];
  robots: Titled[];
  commands: DescribedCommand[];
  formats: Described[];
  metrics: Titled[]; // by which maps can be sorted
}

/* Parameters of a map, as the help has them. */
export interface Group {
  title: string;
  fields: Field[];
}

/* A parameter in a form: a JSON Schema property with what a form needs besides. */
export interface Field {
  required?: boolean; // it does not run without
  missing?: string; // what to say if it is required and not given: "Choose at least one format."
  name: string;
  title: string; // a word or two
  help: string;
  schema: Schema;
  unit: string; // "cm", "%", "units", "s", ""
  default: Json; // null: none, or decided by the program
  slider: [number, number] | null; // from where to where a slider goes, if there is one
  basic: boolean; // shown at once; others under "More"
}

/* The values of a field, in the words of JSON Schema. */
export interface Schema {
  title?: string; // of one of several forms of a value
  type?: "integer" | "number" | "string" | "boolean" | "array" | "null" | ("integer" | "number" | "string" | "boolean" | "array" | "null")[];
  enum?: string[];
  minimum?: number;
  maximum?: number;
  pattern?: string;
  minLength?: number;
  anyOf?: Schema[];
  items?: Schema;
  prefixItems?: Schema[];
  minItems?: number;
  maxItems?: number;
}

/* A kind of obstacle. */
export interface Kind {
  name: string;
  title: string;
  help: string;
  default_place: string; // where it lies without ends
  fields: Field[]; // its own, levels and softness first
  place: Field[]; // first, last, blend, key
}

/* An example or a format. */
export interface Described {
  name: string;
  description: string;
}

/* A robot or a metric. */
export interface Titled {
  name: string;
  title: string;
}

/* A command that may be run. */
export interface DescribedCommand {
  name: string;
  title: string; // in a menu: "Drive over a map"
  help: string;
  group: string; // what it is for: "drive a robot"
  target: "recipe" | "none";
  fields: Field[];
  output: "folder" | "file" | "none";
  output_help: string;
  output_required: boolean;
}

/* A map to choose from. */
export interface Variant {
  seed: number | bigint;
  index: number;
  scene: Drawing;
  difficulty: [string, string][];
}

/* Metrics of a map, and of a robot on it. */
export interface MetricRows {
  rows: [string, string, string, string][]; // name, value, meaning, key
}

/* The id of a document, and the folder of the drive that plays over it, if a drive was opened; else empty. */
export interface OpenedDocument {
  doc: string;
  play: string;
}

/* A drive that was recorded. */
export interface Playback {
  title: string;
  simulator: string;
  robots: PlayedRobot[];
  duration: number;
}

/* A robot of a drive, with what happened to it in order of time. */
export interface PlayedRobot {
  name: string;
  robot: string;
  seconds: number[];
  poses: number[][]; // x y z roll pitch yaw
  events: Mark[];
}

/* An event of a robot. */
export interface Mark {
  second: number;
  text: string;
  kind: "contact" | "trouble" | "success";
}

/* A robot at rest; one that does not stand is level, where it was put. */
export interface DrawnPose {
  stands: boolean;
  holds: boolean;
  pushes: boolean;
  reason: string; // "" or why it is bad: "tips over", "slips", "cannot drive on", "hangs up"
  x: number;
  y: number;
  z: number;
  roll: number;
  pitch: number;
  yaw: number;
  tilt: number;
  centre: [number, number, number]; // of mass
  margin: number; // angle to tip over
  clearance: number | null;
  contacts: [number, number, number][];
  stable: number; // poses in which it may rest here, of which this is one
  polygon: [number, number, number][]; // support polygon, in order
}

/* A rating, with the trials that have been made. */
export interface RatingSoFar {
  robot: string;
  axis: string; // what the levels are
  ticks: number[];
  is_rising: boolean; // whether higher levels are harder
  curves: RatedCurve[];
  can_drive: boolean; // whether a trial can be driven again
}

/* The trials of one judge, and the curve fitted to them. */
export interface RatedCurve {
  judge: string;
  half: string; // in words, with its interval
  points: [number, number, number][]; // level, crossed, trials: several trials near to each other
  line: [number, number, number, number][]; // level, share that is crossed, and the ends of its 95 % interval
  trials: RatedTrial[];
}

/* A robot on one field. */
export interface RatedTrial {
  map: number; // the index of its field
  level: number;
  crossed: boolean | null; // null: it has no result
}

/* The area that a robot can reach. */
export interface DrawnReach {
  text: string; // "crosses west to east"
  region: string; // base64 of uint8 for each cell: 1 where it gets
  ways: Across[];
  spots: StartOrGoal[];
}

/* A spot for a start or a goal. */
export interface StartOrGoal {
  x: number;
  y: number;
  z: number;
  yaw: number;
  name: "S" | "G";
}

/* Everything that pages show of a document. */
export interface State {
  doc: string;
  opens: string; // by what it is opened again after a restart; empty: a new recipe
  revision: number; // counts changes, undo included
  title: string;
  path: string | null;
  unsaved: boolean;
  can_undo: boolean;
  can_redo: boolean;
  values: { [name: string]: Json }; // global parameters
  rows: Row[];
  problem: Problem | null;
  maps: number;
  first_map: number;
  data_set: PlaceInDataSet | null; // that the recipe is the map of
  name: string;
  changed_on_disk: boolean; // somebody else wrote the file
  file_is_gone: boolean; // somebody else removed or renamed it
  recovered: string | null; // changes of a session that ended without saving were brought back: when
  journal: string; // why changes would be lost in a crash, such as a full disk; empty: they would not
  pages: number; // that have it open
}

/* The metrics and costs of a map, which take more work than to draw it. */
export interface MapResults {
  metrics: [string, string, string][]; // name, value, meaning
  cost: string; // "1 model, 1,024 faces, 34 kB"; of a large map, empty
  constraints: string[]; // lines of the constraint report
}

/* A robot as it is drawn. */
export interface RobotShapes {
  name: string;
  title: string;
  size: [number, number, number];
  lift: number; // of the origin of its model in a simulator, above the origin of these parts
  parts: DrawnPart[];
}

/* A part of a robot as it is drawn. */
export interface DrawnPart {
  shape: "box" | "cylinder" | "sphere";
  size: number[]; // box x y z; cylinder radius, length along z; sphere radius
  pose: number[]; // 4x4, row by row, in the robot's frame
  colour: string;
  wheel: boolean;
}

/* The line that does in a shell what a form says. */
export interface ShellLine {
  text: string; // empty while a value is wrong or missing
  why: string; // there is none
}

/* A folder, as a path to copy, and whether a file manager was opened on it. */
export interface ShownFolder {
  path: string;
  is_open: boolean;
}

/* A document as YAML or JSON, as Python, and as a command line. */
export interface Texts {
  recipe: string;
  python: string;
  shell: string;
}

/* Poses of a robot at rest on a regular grid of nx x ny points, x first. */
export interface PoseMap {
  shape: [number, number];
  low: [number, number];
  step: number; // of points, metres
  tilt: string; // base64 of float32, NaN where it does not stand
  margin: string; // the same of the angle to tip over
  reason: string; // base64 of uint8, an index into reasons
  reasons: string[];
}

/* A way of a robot between two places. */
export interface DrawnWay {
  found: boolean;
  text: string;
  poses: [number, number, number, number, number, number][]; // x y z roll pitch yaw of the robot's origin
  events: WayEvent[];
  length: number;
  worst_tilt: number;
  least_margin: number;
  least_margin_at: [number, number]; // x and y of the robot's origin
}

/* An event on a way: a drop, or a slip. */
export interface WayEvent {
  at: number; // the number of the pose
  text: string;
}

/* A document has changed. */
export interface StateChanged {
  event: "state";
  state: State;
  page: string; // that changed it
}

/* A job of a document has changed. */
export interface JobChanged {
  event: "job";
  job: Job;
}

/* Somebody else wrote the file of a document, or took that back. */
export interface FileChanged {
  event: "file";
  changed_on_disk: boolean;
}

/* Progress of a search, 0 to 1, or of one of its steps. */
export interface SearchProgress {
  event: "progress";
  of: "tilt" | "reach" | "crossing" | "way" | "measure" | "variants";
  step: string; // in words; empty if it has one alone
  share: number;
}

/* The server lives. */
export interface Alive {
  event: "alive";
}

/* The reason why a call failed. */
export interface Failure {
  kind?: "exists" | "changed";
  where: string; // the parameter, as in obstacles[2].softness
  text: string;
}

/* The maps in a page that is a file. */
export interface Frozen {
  maps: MapData[];
  version: string;
}

/* A map as it is drawn, with its metrics: all that a page has of it that is a file. */
export interface MapData {
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
  recipe: string;
  file: string;
  look: string;
  step: number; // metres of a unit
  metrics: [string, string, string][]; // name, value, meaning
}

export type Search = "tilt" | "reach" | "crossing" | "way" | "measure" | "variants";

export type Event = StateChanged | JobChanged | FileChanged | SearchProgress | Alive;

/* Changes of a document, of the map that the page shows. */
export type Action =
  /* Add an obstacle, in line where its kind must be axis-aligned. */
  | { do: "add"; entry: Entry; at?: number | null }
  /* Replace the parameters of a row; a key that it was given stays, and whether it is switched on. */
  | { do: "change"; row: number; entry: Entry; gesture?: string | null }
  /* Remove all rows. */
  | { do: "clear" }
  /* Copy a row to the row below it. */
  | { do: "duplicate"; row: number }
  /* Switch a row on or off. */
  | { do: "enable"; row: number; enabled: boolean }
  /* Make random ends the cells where they are in a map. */
  | { do: "fix"; row: number; index: number }
  /* Move a row in the list; later obstacles are imposed on earlier ones. */
  | { do: "move"; row: number; to: number }
  /* Move an end of an obstacle, or both, to a cell; random ends are fixed where they are in the map shown. */
  | { do: "move_end"; row: number; end: "first" | "last" | "both"; cell: [number, number]; gesture?: string | null }
  /* Give cells a level, in a matrix or, if the row is none that can be painted into, in a new one. */
  | { do: "paint"; row: number; cells: [number, number][]; level: number; gesture?: string | null }
  /* Redo the change that was undone last. */
  | { do: "redo" }
  /* Remove a row. */
  | { do: "remove"; row: number }
  /* Draw another seed, short enough to be read out and typed. */
  | { do: "reroll" }
  /* Change a global parameter; None gives it back its default, of which a seed has none. */
  | { do: "set"; name: string; value: Json; gesture?: string | null }
  /* Undo the last change. */
  | { do: "undo" };

/* What a page may ask for: the arguments, and the result. */
export interface Calls {
  /* Ask a job to stop. */
  cancel: { args: { job: number }; result: Job };
  /* Close a document, and discard what is not saved; one that another page has open stays. */
  close: { args: { doc: string }; result: null };
  /* Return how surely a robot gets across a map, with all its drives. */
  crossing: { args: { doc: string; index: number; robot: string }; result: DrawnCrossing };
  /* Drive a trial again in MuJoCo, as a job that writes a drive next to the folder of its rating. */
  drive_trial: { args: { doc: string; path: string; judge: string; trial: number }; result: Job };
  /* Change a document by some actions, all or none of them, and return its state and the row to select. */
  edit: { args: { doc: string; actions: Action[]; page?: string; index?: number | null }; result: EditedState };
  /* Return the first map of each example as a small picture is drawn of it, by its name. */
  example_maps: { args: {}; result: { [name: string]: Drawing } };
  /* List a folder: recipes, folders of maps with their recipe, data sets, drives, folders and other files. */
  files: { args: { folder?: string }; result: Listing };
  /* Return a map of a document as it would be with another obstacle at the end of the list, drawn as it will be. */
  ghost: { args: { doc: string; entry: Entry; index?: number | null; page?: string }; result: DocumentMap };
  /* Return what is the same for all documents: forms, kinds, robots, formats, metrics that need no robot. */
  hello: { args: {}; result: Hello };
  /* Return all jobs. */
  jobs: { args: {}; result: Job[] };
  /* Return the maps of recipes in the folder of the page, the first of each: of what a command has just written. */
  made_maps: { args: { paths: string[] }; result: Variant[] };
  /* Return `count` maps of a document's recipe from the place `first` on in their order, or as many as there are. */
  maps: { args: { doc: string; first: number; count: number; by?: string }; result: Variant[] };
  /* Return all metrics of a map as rows of name, value, unit or meaning, and key; with a robot, also its own. */
  measure: { args: { doc: string; index: number; robot?: string | null }; result: MetricRows };
  /* Open a new recipe, a file, an example, a map of a data set, or a drive with its map. */
  open: { args: { what?: string }; result: OpenedDocument };
  /* Return the drive that a folder holds. */
  playback: { args: { path: string }; result: Playback };
  /* Return how a robot rests that is put down level at x, y with a heading; also next to the map. */
  pose: { args: { doc: string; index: number; robot: string; x: number; y: number; heading: number }; result: DrawnPose };
  /* Return the rating that a folder holds, also of a command that still runs; a UserError until a trial has ended. */
  rating: { args: { path: string }; result: RatingSoFar };
  /* Return the area that a robot reaches on a map, its ways across, and a start and a goal for it. */
  reach: { args: { doc: string; index: number; robot: string }; result: DrawnReach };
  /* Take over what is in the file. */
  reload: { args: { doc: string; page?: string }; result: State };
  /* Return what is measured of a map of a document, and what it costs; of a draft that is invalid, as `scene`. */
  results: { args: { doc: string; index?: number | null; page?: string }; result: MapResults };
  /* Return a robot as it is drawn: the parts of its links; for a robot of a file, its visuals. */
  robot: { args: { robot: string }; result: RobotShapes };
  /* Run a command on the recipe of a document; a Question if it would replace what it may replace. */
  run: { args: { doc: string; command: string; values: { [name: string]: Json }; output?: string; target?: string; replace?: boolean }; result: Job };
  /* Write a document to its file, or to another one in the folder. */
  save: { args: { doc: string; path?: string; replace?: boolean; page?: string }; result: State };
  /* Return a map of a document as it is drawn; if the draft is invalid, a map of the last valid recipe. */
  scene: { args: { doc: string; index?: number | null; page?: string }; result: DocumentMap };
  /* Return the shell line that does what `run` does with these arguments, or why it cannot be given. */
  shell_line: { args: { doc: string; command: string; values: { [name: string]: Json }; output?: string; target?: string }; result: ShellLine };
  /* Open the file manager on a folder, or on the folder of a file; only a person at this machine sees it. */
  show_folder: { args: { path: string }; result: ShownFolder };
  /* Return all that pages show of a document; index: the map that the page shows. */
  state: { args: { doc: string; page?: string; index?: number | null }; result: State };
  /* Stop a search that is done for a page of a document. */
  stop: { args: { doc: string; of: "tilt" | "reach" | "crossing" | "way" | "measure" | "variants" }; result: null };
  /* Return the document as the text of its file, as Python, and as a command line. */
  texts: { args: { doc: string }; result: Texts };
  /* Return how a robot of one heading rests on a grid of places all over a map. */
  tilt: { args: { doc: string; index: number; robot: string; heading: number }; result: PoseMap };
  /* Return the first map of a document's recipe at fresh seeds. */
  variants: { args: { doc: string; count: number }; result: Variant[] };
  /* Return the best way of a robot between two places, pose by pose, with its falls and slides. */
  way: { args: { doc: string; index: number; robot: string; start: [number, number]; goal: [number, number]; best?: "safe" | "length" | "tilt" | "margin" }; result: DrawnWay };
}
