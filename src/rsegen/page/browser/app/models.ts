/* Robots in the 3D view: their parts, how they rest on blocks, and drives that are played again. */

import {
  Box3, BoxGeometry, BufferAttribute, BufferGeometry, CanvasTexture, Color, CylinderGeometry, DoubleSide, Euler, Group,
  Matrix4, Mesh, MeshBasicMaterial, MeshLambertMaterial, Quaternion, SRGBColorSpace, SphereGeometry, Sprite,
  SpriteMaterial, Vector3, type Object3D,
} from "three";
import { LineMaterial } from "three/examples/jsm/lines/LineMaterial.js";
import { LineSegments2 } from "three/examples/jsm/lines/LineSegments2.js";
import { LineSegmentsGeometry } from "three/examples/jsm/lines/LineSegmentsGeometry.js";
import { BAD, GOOD, MARKS, TRAILS } from "./colours";
import { lettered, type Point } from "./field";
import type { Playback, DrawnPose, RobotShapes } from "./protocol";

const RED = new Color(BAD);
const LETTER = 0.019; // of a distance: 24 pixels in a view of 700

export interface Pen { colour: string; width: number; opacity?: number; hidden?: boolean; dash?: number }

/* Lines between pairs of points, some CSS pixels wide. hidden: blocks do not hide them; dash: metres. */
export function linesOf(points: Point[], { colour, width, opacity = 1, hidden = false, dash = 0 }: Pen): LineSegments2 {
  const geometry = new LineSegmentsGeometry().setPositions(new Float32Array(points.flat()));
  const material = new LineMaterial({ color: colour, linewidth: width, opacity, transparent: true, depthTest: !hidden });
  if (dash) Object.assign(material, { dashed: true, dashSize: dash, gapSize: 0.7 * dash });
  // Lines on tops are nearer to the camera than the tops.
  Object.assign(material, { polygonOffset: true, polygonOffsetFactor: -2, polygonOffsetUnits: -4 });
  const lines = new LineSegments2(geometry, material);
  if (dash) lines.computeLineDistances();
  lines.renderOrder = hidden ? 3 : 2;
  return lines;
}

/* The pairs of a line through points. */
export function pairs(points: Point[]): Point[] {
  return points.slice(1).flatMap((point, k) => [points[k], point]);
}

/* Free what an object and its parts hold on the graphics card, and take it out of its scene.
   Materials stay: they hold programs, of which there are few, and linking them anew takes longer than a map. */
export function drop(object: Object3D | null): void {
  object?.traverse((part) => {
    if (part instanceof Sprite) part.material.map?.dispose(); // the geometry of sprites is one for all
    if (part instanceof Mesh) part.geometry.dispose();
  });
  object?.removeFromParent();
}

export class Robot {
  readonly group = new Group();
  private readonly materials: { material: MeshLambertMaterial; colour: Color }[] = [];

  constructor(readonly drawing: RobotShapes) {
    for (const part of drawing.parts) {
      const material = new MeshLambertMaterial({ color: part.colour });
      const mesh = new Mesh(shapeOf(part), material);
      mesh.matrixAutoUpdate = false;
      mesh.matrix = new Matrix4().fromArray(part.pose).transpose();
      mesh.castShadow = true;
      this.materials.push({ material, colour: new Color(part.colour) });
      this.group.add(mesh);
    }
  }

  put(position: Vector3, rotation: Quaternion): void {
    this.group.position.copy(position);
    this.group.quaternion.copy(rotation);
  }

  tint(isBad: boolean): void {
    for (const { material, colour } of this.materials) {
      material.color.copy(colour);
      if (isBad) material.color.lerp(RED, 0.7);
      material.emissive.copy(RED).multiplyScalar(isBad ? 0.16 : 0);
    }
  }
}

/* Where the parts of a robot are along x and y in its own frame: lowest and highest x, lowest and highest y. */
export function boundsOf(drawing: RobotShapes): [number, number, number, number] {
  const bounds: [number, number, number, number] = [Infinity, -Infinity, Infinity, -Infinity];
  for (const { shape, size: [a, b, c], pose } of drawing.parts) {
    const half = shape === "box" ? [a / 2, b / 2, c / 2] : shape === "cylinder" ? [a, a, b / 2] : [a, a, a];
    for (const axis of [0, 1]) {
      const [x, y, z, from] = pose.slice(4 * axis, 4 * axis + 4);
      const reach = Math.abs(x) * half[0] + Math.abs(y) * half[1] + Math.abs(z) * half[2];
      bounds[2 * axis] = Math.min(bounds[2 * axis], from - reach);
      bounds[2 * axis + 1] = Math.max(bounds[2 * axis + 1], from + reach);
    }
  }
  return bounds;
}

function shapeOf(part: RobotShapes["parts"][number]): BufferGeometry {
  const [a, b, c] = part.size;
  if (part.shape === "box") return new BoxGeometry(a, b, c);
  if (part.shape === "sphere") return new SphereGeometry(a, 24, 16);
  return new CylinderGeometry(a, a, b, 32).rotateX(Math.PI / 2); // along z, as in URDF
}

/* Rotation of roll, pitch and yaw about fixed axes, as in SDF and URDF. */
export function rotationOf(roll: number, pitch: number, yaw: number): Quaternion {
  return new Quaternion().setFromEuler(new Euler(roll, pitch, yaw, "ZYX"));
}

/* Where a robot touches the blocks, the hull of these points, and the plumb line of its centre of mass, which must meet it. */
export function restOf(pose: DrawnPose, size: number): Group {
  const group = new Group();
  const colour = pose.stands && pose.holds ? GOOD : BAD;
  const { polygon, contacts, centre } = pose;
  if (polygon.length > 2) {
    const face = new BufferGeometry();
    face.setAttribute("position", new BufferAttribute(new Float32Array(polygon.flat()), 3));
    face.setIndex(polygon.slice(2).flatMap((_, k) => [0, k + 1, k + 2]));
    const pale = { color: colour, transparent: true, opacity: 0.3 };
    const fill = new MeshBasicMaterial({ ...pale, side: DoubleSide, depthTest: false });
    const mesh = new Mesh(face, fill);
    mesh.renderOrder = 3;
    group.add(mesh, linesOf(pairs([...polygon, polygon[0]]), { colour, width: 2.5, hidden: true }));
  }
  if (polygon.length) {
    const ground = Math.min(...polygon.map(([, , z]) => z));
    group.add(linesOf([centre, [centre[0], centre[1], ground]], { colour: "#ffffff", width: 5, hidden: true }));
    group.add(linesOf([centre, [centre[0], centre[1], ground]], { colour, width: 2.5, hidden: true }), dot(centre, 1.3 * size, "#ffffff"), dot(centre, size, colour));
  }
  for (const contact of contacts) group.add(dot(contact, size, colour));
  return group;
}

/* A ball that is seen through blocks. */
export function dot(point: Point, radius: number, colour: string, opacity = 1): Mesh {
  const material = new MeshBasicMaterial({ color: colour, transparent: true, opacity, depthTest: false });
  const mesh = new Mesh(new SphereGeometry(radius, 16, 10), material);
  mesh.position.set(...point);
  mesh.renderOrder = 4;
  return mesh;
}

/* A letter on a disc of a colour, as large however far it is, and seen through blocks. */
export function letter(point: Point, text: string, colour: string): Sprite {
  const canvas = document.createElement("canvas");
  canvas.width = canvas.height = 64;
  lettered(canvas.getContext("2d")!, [32, 32], 29, text, colour);
  const map = new CanvasTexture(canvas);
  map.colorSpace = SRGBColorSpace;
  const sprite = new Sprite(new SpriteMaterial({ map, depthTest: false, sizeAttenuation: false }));
  sprite.position.set(...point);
  sprite.scale.setScalar(LETTER);
  sprite.renderOrder = 5;
  return sprite;
}

interface Track {
  robot: Robot | null;
  trail: LineSegments2;
  seconds: number[];
  poses: number[][];
  marks: [number, Mesh][]; // when something happened, and its ball
}

/* A drive that is played: its robots, what they drove, and marks where something happened. */
export class Player {
  readonly group = new Group();
  private readonly tracks: Track[];

  constructor(playback: Playback, drawings: Map<string, RobotShapes>, size: number) {
    const driven = playback.robots.filter(({ poses }) => poses.length > 0);
    this.tracks = driven.map(({ robot: kind, seconds, poses, events }, k) => {
      const colour = TRAILS[k % TRAILS.length];
      const points = poses.map(([x, y, z]): Point => [x, y, z]);
      const drawing = drawings.get(kind);
      const robot = drawing ? new Robot(drawing) : null;
      const whole = linesOf(pairs(points), { colour, width: 1.5, opacity: 0.35, hidden: true });
      const trail = linesOf(pairs(points), { colour, width: 3.5, hidden: true });
      const marks = events.map(({ second, kind }): [number, Mesh] => {
        const { position } = poseAt(seconds, poses, second);
        return [second, dot([position.x, position.y, position.z], (kind === "contact" ? 0.8 : 1.6) * size, MARKS[kind], 0.35)];
      });
      this.group.add(whole, trail, ...marks.map(([, mark]) => mark));
      if (robot) this.group.add(robot.group);
      return { robot, trail, seconds, poses, marks };
    });
    this.at(0);
  }

  at(second: number): void {
    for (const { robot, trail, seconds, poses, marks } of this.tracks) {
      const { position, rotation } = poseAt(seconds, poses, second);
      // A simulator's model has its origin above that of what is drawn.
      robot?.put(position.sub(new Vector3(0, 0, robot.drawing.lift).applyQuaternion(rotation)), rotation);
      trail.geometry.instanceCount = Math.max(0, before(seconds, second));
      for (const [when, mark] of marks) (mark.material as MeshBasicMaterial).opacity = when <= second ? 1 : 0.35;
    }
  }

  /* Around where each robot is at any time, whichever way it looks. */
  get boxes(): Box3[] {
    return this.tracks.map(({ robot, poses }) => {
      const reach = robot ? Math.max(...boundsOf(robot.drawing).map(Math.abs)) : 0;
      return poses.reduce((box, [x, y, z]) => box.expandByPoint(new Vector3(x, y, z)), new Box3()).expandByScalar(reach);
    });
  }

  /* Where the robots are now. */
  get robots(): Group[] {
    return this.tracks.flatMap(({ robot }) => (robot ? [robot.group] : []));
  }
}

/* The last sample that is not after a time. */
function before(seconds: number[], second: number): number {
  let [low, high] = [0, seconds.length - 1];
  while (low < high) {
    const middle = (low + high + 1) >> 1;
    if (seconds[middle] <= second) low = middle;
    else high = middle - 1;
  }
  return low;
}

/* The pose at a time, between the samples before and after it. */
export function poseAt(
  seconds: number[], poses: number[][], second: number,
): { position: Vector3; rotation: Quaternion } {
  const from = before(seconds, second);
  const to = Math.min(from + 1, poses.length - 1);
  const [a, b] = [poses[from], poses[to]];
  const part = to > from ? Math.min(1, Math.max(0, (second - seconds[from]) / (seconds[to] - seconds[from] || 1))) : 0;
  return {
    position: new Vector3(a[0], a[1], a[2]).lerp(new Vector3(b[0], b[1], b[2]), part),
    rotation: rotationOf(a[3], a[4], a[5]).slerp(rotationOf(b[3], b[4], b[5]), part),
  };
}
