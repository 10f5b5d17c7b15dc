/* A map on its floor, under sun and sky, and from where it is looked at: what views and thumbnails draw. z is up. */

import {
  Box3, CanvasTexture, Color, DirectionalLight, HemisphereLight, LinearFilter, Mesh, MeshLambertMaterial, NearestFilter,
  Object3D, PCFShadowMap, PerspectiveCamera, PlaneGeometry, SRGBColorSpace, Scene, SphereGeometry,
  Vector3, WebGLRenderer,
} from "three";
import { blocksOf } from "./blocks";
import type { Field } from "./field";
import { lightOn } from "./light";
import { DARK, LIGHT, SUN_AT, asWritten, blockMaterial, floorMaterial, setLight, skyMaterial, uniforms } from "./materials";
import type { Overlay } from "./overlay";
import type { Options } from "./views";

export type From = "oblique" | "above" | "south" | "east";
const DIRECTIONS: Record<From, [number, number, number]> = {
  oblique: [0.47, -0.95, 0.8], above: [0, -1e-4, 1], south: [0, -1, 0.28], east: [1, 0, 0.28],
};

export function rendererOf(canvas: HTMLCanvasElement): WebGLRenderer {
  const renderer = new WebGLRenderer({ canvas, antialias: true, powerPreference: "high-performance" });
  renderer.shadowMap.enabled = true;
  renderer.shadowMap.type = PCFShadowMap;
  renderer.shadowMap.autoUpdate = false;
  return renderer;
}

export class Stage {
  readonly scene = new Scene();
  readonly camera = new PerspectiveCamera(30, 1, 0.01, 1000);
  readonly target = new Vector3(); // that the camera looks at
  drives: Box3[] = []; // around where each robot drives: they are looked at with the map
  field: Field | null = null;
  radius = 1;
  private readonly shared = uniforms();
  private readonly blocks = new Mesh(undefined, blockMaterial(this.shared));
  private readonly floor = new Mesh(new PlaneGeometry(), floorMaterial(this.shared));
  private readonly sky = new Mesh(new SphereGeometry(1, 24, 16), skyMaterial(this.shared));
  private readonly sun = new DirectionalLight("#fff1dc", 2.85);
  private readonly ambient = new HemisphereLight("#e8efff", "#a39a8c", 1.35);

  constructor() {
    this.camera.up.set(0, 0, 1);
    this.ambient.position.set(0, 0, 1); // the sky is where z is
    this.sky.frustumCulled = this.floor.frustumCulled = false;
    // From the front to the back: no pixel is coloured in vain.
    this.floor.renderOrder = 0.1;
    this.sky.renderOrder = 0.2;
    this.sun.shadow.mapSize.set(1024, 1024);
    this.sun.shadow.radius = 3;
    this.blocks.visible = false;
    this.scene.add(this.sky, this.floor, this.blocks, this.sun, this.sun.target, this.ambient);
    this.dress({ dark: false, grid: true });
  }

  show(field: Field, { look, dark }: Pick<Options, "look" | "dark">): void {
    this.field = field;
    this.blocks.geometry.dispose();
    this.blocks.geometry = blocksOf(field, { look, floor: (dark ? DARK : LIGHT).floor, isSeen: () => true });
    this.blocks.visible = true;
    this.shared.light.value?.dispose();
    setLight(this.shared, lightOn(field), field.width);
    this.radius = Math.hypot(field.nX * field.width, field.nY * field.width, field.highest) / 2;
    this.shared.radius.value = this.radius;
    this.shared.joints.value = this.radius > 12 ? 10 : 1;
    this.floor.scale.set(60 * this.radius, 60 * this.radius, 1);
    this.floor.position.z = -0.0006 * this.radius; // below tops of height 0
  }

  dress({ dark, grid }: { dark: boolean; grid: boolean }): void {
    const colours = dark ? DARK : LIGHT;
    (this.floor.material as MeshLambertMaterial).color = new Color(colours.floor);
    this.shared.joint.value = new Color(colours.joint);
    this.shared.horizon.value = asWritten(colours.horizon);
    this.shared.zenith.value = asWritten(colours.zenith);
    this.shared.grid.value = grid ? 1 : 0;
    this.ambient.intensity = dark ? 1.15 : 1.35;
  }

  /* Lay a picture over the tops; null takes it away. */
  overlay(overlay: Overlay | null): void {
    const material = this.blocks.material as MeshLambertMaterial;
    this.shared.overlay.value?.dispose();
    this.shared.overlay.value = null;
    if (overlay) {
      const texture = new CanvasTexture(overlay.canvas);
      texture.colorSpace = SRGBColorSpace;
      texture.magFilter = NearestFilter;
      texture.minFilter = LinearFilter;
      texture.generateMipmaps = false;
      this.shared.overlay.value = texture;
      this.shared.overlayLow.value.set(...overlay.low);
      this.shared.overlaySize.value.set(...overlay.size);
    }
    if (Boolean(overlay) === Boolean(material.defines?.HAS_OVERLAY)) return;
    material.defines = { ...material.defines, HAS_OVERLAY: overlay ? 1 : undefined };
    if (!overlay) delete material.defines.HAS_OVERLAY;
    material.needsUpdate = true;
  }

  /* Let robots cast a shadow on blocks and floor: the only one that is not known beforehand. */
  cast(robots: Object3D[]): void {
    const casts = robots.length > 0;
    this.sun.castShadow = this.blocks.receiveShadow = this.floor.receiveShadow = casts;
    if (!casts) return;
    const box = new Box3();
    robots.forEach((robot) => (robot.updateWorldMatrix(true, true), box.expandByObject(robot))); // its parts move with it
    const [middle, half] = [box.getCenter(new Vector3()), 0.75 * box.getSize(new Vector3()).length() + 0.05];
    this.sun.target.position.copy(middle);
    this.sun.position.copy(SUN_AT).multiplyScalar(10 * half).add(middle);
    const { camera } = this.sun.shadow;
    Object.assign(camera, { left: -half, right: half, top: half, bottom: -half, near: 5 * half, far: 20 * half });
    camera.updateProjectionMatrix();
    this.sun.shadow.normalBias = 0.004 * half;
    this.sun.shadow.bias = -0.002;
  }

  render(renderer: WebGLRenderer): void {
    if (!this.sun.castShadow) this.sun.position.copy(SUN_AT).multiplyScalar(this.radius).add(this.sun.target.position);
    // 24 bits of depth tell points at a distance d apart if they are d² / (2²⁴ near): with a near plane that goes along, the floor
    // and tops of height 0 from everywhere.
    this.camera.near = this.camera.position.distanceTo(this.target) / 50;
    this.camera.updateProjectionMatrix();
    renderer.shadowMap.needsUpdate = this.sun.castShadow;
    renderer.render(this.scene, this.camera);
  }

  /* Look at the whole map and a whole drive from a direction, from as near as both are seen whole. */
  look(from: From): number {
    const { field, camera, target } = this;
    if (!field) return 1;
    const map = new Box3(new Vector3(field.x(0), field.y(0), 0), new Vector3(field.x(field.nX), field.y(field.nY), field.highest));
    // A robot that fell off, or that a simulator threw away, does not make the map small.
    const around = map.clone().expandByScalar(this.radius);
    const boxes = [map, ...this.drives.map((box) => box.clone().intersect(around)).filter((box) => !box.isEmpty())];
    const { x, y } = boxes.reduce((all, box) => all.union(box), new Box3()).getCenter(new Vector3());
    target.set(x, y, 0.35 * field.highest);
    camera.far = 80 * this.radius;
    camera.updateProjectionMatrix();
    const corners = boxes.flatMap(({ min, max }) => [0, 1, 2, 3, 4, 5, 6, 7].map(
      (k) => new Vector3(k & 1 ? max.x : min.x, k & 2 ? max.y : min.y, k & 4 ? max.z : Math.max(0, min.z)),
    ));
    const isWhole = (away: number) => {
      camera.position.set(...DIRECTIONS[from]).setLength(away).add(target);
      camera.lookAt(target);
      camera.updateMatrixWorld();
      return corners.every((corner) => {
        const { x, y, z } = corner.clone().project(camera);
        return Math.max(Math.abs(x), Math.abs(y)) < 0.92 && z < 1;
      });
    };
    let [near, far] = [this.radius, 40 * this.radius];
    for (let k = 0; k < 20; k++) {
      const middle = (near + far) / 2;
      if (isWhole(middle)) far = middle;
      else near = middle;
    }
    isWhole(far);
    return far;
  }

  dispose(): void {
    this.overlay(null);
    this.shared.light.value?.dispose();
    for (const { geometry, material } of [this.blocks, this.floor, this.sky]) {
      geometry.dispose();
      material.dispose();
    }
  }
}
