/* What the 3D view and the plan have in common: what they are told, and what they say of the mouse.

   Solid of solid.ts and Plan of plan.ts are made of their host element and what they tell. Both draw into their host element, follow
   its size, and draw only when something changed. Neither knows the server, nor keeps what the document says. */

import type { Cell, Playback, DrawnPose, PoseMap, DrawnCrossing, DrawnReach, RobotShapes, SceneData, DrawnWay } from "./protocol";

/* What the mouse does. select: pick obstacles, drag their ends and the middle, raise them by a drag of their top handle;
   paint: cells get a level; draw: a drag gives a new obstacle its two ends; robot: it settles where the mouse is;
   way: two clicks are start and goal. Dragging beside the map, or with the right or middle button, moves the camera. */
export type Tool =
  | { name: "select" }
  | { name: "paint"; shape: "cells" | "rectangle" | "fill" | "pick"; level: number } // -1: erase
  | { name: "draw" }
  | { name: "robot"; heading: number }
  | { name: "way" };

export interface ViewEvents {
  hover?(at: Hover | null): void; // what is below the mouse; null: nothing
  pick?(row: number, cell: Cell | null): void; // a click with select; row -1: none
  chunk?(): number; // cells along the side of a chunk, by which Shift and an arrow key move an end
  moveEnd?(row: number, end: "first" | "last" | "both", cell: Cell, gesture: string): void; // while it is dragged
  raise?(row: number, levels: number, gesture: string): void; // its number of levels, while its handle is dragged
  paint?(cells: Cell[], level: number, gesture: string): void;
  picked?(level: number): void; // by the tool pick
  draw?(first: Cell, last: Cell): void; // the drag has ended
  robotAt?(x: number, y: number): void; // metres, with the tool robot
  robotPut?(x: number, y: number): void; // a click with it
  wayPoint?(x: number, y: number): void; // a click with way
  turn?(by: number): void; // the wheel with Shift, with robot: radians
}

export interface Hover {
  i: number; j: number; // of the field, frames included
  cell: Cell | null; // of blocks; null on a frame
  row: number; // of the obstacle that made it; -1: none
  label: string; // "30 cm", "frame"
  x: number; y: number; z: number; // metres
}

export interface View {
  show(scene: SceneData | null): void; // keeps the camera if the map has the same size
  set(options: Partial<Options>): void;
  tool(tool: Tool): void;
  select(row: number): void; // its cells are outlined, its handles shown
  ghost(scene: SceneData | null, row: number): void; // an obstacle that is not added yet: only cells of this owner
  robot(drawing: RobotShapes | null, pose: DrawnPose | null): void; // red where it does not stand, contacts and polygon
  poseMap(map: PoseMap | null, shown: "tilt" | "margin" | "reason"): void; // coloured over the blocks
  reach(reach: DrawnReach | null, crossing?: DrawnCrossing | null): void; // drives of a prediction take the place of ways
  way(way: DrawnWay | null, start: [number, number] | null): void;
  play(playback: Playback | null, drawings: Map<string, RobotShapes>): void; // by name of the kind of robot
  at(second: number): void; // of the playback
  look(from: "oblique" | "above" | "south" | "east"): void;
  picture(width: number, height: number): Promise<Blob>; // PNG
  dispose(): void;
}

export interface Options {
  look: "recipe" | "heights"; // materials of the recipe, such as wood; or one colour per height
  grid: boolean; // lines between cells
  axes: boolean;
  dark: boolean; // the colours around the map
}
