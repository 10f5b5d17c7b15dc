/* How blocks, floor and sky are lit and coloured. All three share the light of the map and the colours around it. */

import {
  BackSide, Color, MeshLambertMaterial, ShaderMaterial, Vector2, Vector3, type IUniform, type Texture,
} from "three";
import { SUN, type Light } from "./light";
import { MEAN, grainOf } from "./wood";

type Uniforms = Record<string, IUniform>;

export interface Surroundings { floor: string; joint: string; horizon: string; zenith: string }
export const LIGHT: Surroundings = { floor: "#c6c1b8", joint: "#8f8b84", horizon: "#e9ecf0", zenith: "#bccbdd" };
export const DARK: Surroundings = { floor: "#3a3c40", joint: "#55585e", horizon: "#1b1e23", zenith: "#101216" };

/* What the materials of a map have in common; they change together. */
export function uniforms(): Uniforms {
  return {
    light: { value: null as Texture | null },
    lightLow: { value: new Vector2() },
    lightSize: { value: new Vector2(1, 1) },
    lightFall: { value: 1 },
    lightTexel: { value: 1 },
    block: { value: 1 },
    grain: { value: grainOf() },
    overlay: { value: null as Texture | null },
    overlayLow: { value: new Vector2() },
    overlaySize: { value: new Vector2(1, 1) },
    joints: { value: 1 },
    horizon: { value: new Color() },
    zenith: { value: new Color() },
    joint: { value: new Color() },
    radius: { value: 1 },
    fades: { value: new Vector2(1.6, 8) },
    grid: { value: 1 },
  };
}

export function setLight(shared: Uniforms, light: Light, block: number): void {
  shared.light.value = light.texture;
  shared.lightLow.value = light.low;
  shared.lightSize.value = light.size;
  shared.lightFall.value = light.fall;
  shared.lightTexel.value = light.texel;
  shared.block.value = block;
}

/* Light at a point: x, how much of the sun; y, how much of the sky. */
const LIT = `
uniform sampler2D light;
uniform vec2 lightLow, lightSize;
uniform float lightFall, lightTexel, block;
vec2 litAt(vec3 point, vec3 facing) {
  vec2 plan = point.xy + 1.5 * lightTexel * facing.xy; // a side is lit as what lies before it
  vec2 dark = texture2D(light, (plan.yx - lightLow.yx) / lightSize.yx).rg;
  float sun = smoothstep(0.0, 0.85 * lightFall, point.z - dark.x + 0.02 * lightFall);
  float deep = max(0.0, dark.y - point.z) / block;
  float open = 1.0 - 0.66 * deep / (deep + 0.45);
  return vec2(sun, open);
}`;

/* What both surfaces do with it, after three.js has summed up sun (direct) and sky (indirect). */
const shaded = (facing: string) => `#include <lights_fragment_end>
  vec2 lit = litAt(vPlace, ${facing});
  reflectedLight.directDiffuse *= lit.x * mix(1.0, lit.y, 0.35);
  reflectedLight.indirectDiffuse *= lit.y;`;

/* Blocks: colour of the face times its grain, a groove along its edges, and the overlay on tops. */
export function blockMaterial(shared: Uniforms): MeshLambertMaterial {
  const material = new MeshLambertMaterial();
  material.onBeforeCompile = (shader) => {
    Object.assign(shader.uniforms, shared);
    shader.vertexShader = shader.vertexShader
      .replace(
        "#include <common>",
        `#include <common>
        attribute vec4 colour, face;
        uniform float block;
        varying vec3 vPlace, vColour, vFacing, vGrain;
        varying vec2 vFace;
        varying vec4 vEdges;
        varying float vStrength, vLine;`,
      )
      .replace(
        "#include <beginnormal_vertex>",
        `float side = face.x;
        vec3 objectNormal = side < 0.5 ? vec3(0.0, 0.0, 1.0) : side < 1.5 ? vec3(-1.0, 0.0, 0.0)
          : side < 2.5 ? vec3(1.0, 0.0, 0.0) : side < 3.5 ? vec3(0.0, -1.0, 0.0) : vec3(0.0, 1.0, 0.0);`,
      )
      .replace(
        "#include <begin_vertex>",
        `vec3 transformed = position;
        // Every face has four corners, so the number of a corner tells its place.
        int corner = gl_VertexID % 4;
        vFace = vec2(corner == 1 || corner == 2 ? 1.0 : 0.0, corner > 1 ? 1.0 : 0.0);
        vec4 none = 1.0 - mod(floor(colour.w / vec4(1.0, 2.0, 4.0, 8.0)), 2.0);
        vEdges = vec4(vFace.x, 1.0 - vFace.x, vFace.y, 1.0 - vFace.y) + 9.0 * none;
        vPlace = position;
        vFacing = objectNormal;
        // From the colours of screens to light, to a thousandth, without a power.
        vec3 shown = colour.rgb / 255.0;
        vColour = shown * (shown * (shown * 0.3053 + 0.6822) + 0.0125);
        float varied = floor(face.z / 2.0);
        vec2 fibre = vec2(side < 0.5 ? position.x : vFace.x, side < 0.5 ? position.y : position.z) / block;
        if (side > 2.5 && mod(face.z, 2.0) > 0.5) fibre.x = position.x / block;
        else if (side > 0.5 && mod(face.z, 2.0) > 0.5) fibre.x = position.y / block;
        if (mod(face.z, 2.0) > 0.5) fibre = fibre.yx;
        // End grain is turned over for variety; long grain starts anywhere along the post.
        vec2 end = varied < 4.0 ? vFace : vFace.yx;
        end = vec2(mod(varied, 2.0) > 0.5 ? 1.0 - end.x : end.x, mod(varied, 4.0) > 1.5 ? 1.0 - end.y : end.y);
        vGrain = vec3(face.y < 15.5 ? end : vec2(fibre.x, 0.5 * fibre.y + 0.37 * varied), face.y);
        vStrength = face.w / 255.0;
        vLine = colour.w > 15.5 ? 0.2 : 0.55;
        vColour *= 1.0 + (0.1 * vStrength + 0.02) * (varied / 3.5 - 1.0);`,
      );
    shader.fragmentShader = shader.fragmentShader
      .replace(
        "#include <common>",
        `#include <common>
        precision highp sampler2DArray;
        uniform sampler2DArray grain;
        uniform sampler2D overlay;
        uniform vec2 overlayLow, overlaySize;
        uniform float grid;
        varying vec3 vPlace, vColour, vFacing, vGrain;
        varying vec2 vFace;
        varying vec4 vEdges;
        varying float vStrength, vLine;
        ${LIT}`,
      )
      .replace(
        "#include <color_fragment>",
        `float tone = texture(grain, vec3(vGrain.xy, floor(vGrain.z + 0.5))).r;
        // Where wood is dark it is also redder; paint is not.
        tone /= ${MEAN.toFixed(3)};
        vec3 wood = vStrength > 0.9 ? vec3(tone, tone * sqrt(tone), tone * tone) : vec3(tone);
        diffuseColor.rgb = vColour * mix(vec3(1.0), wood, vStrength);
        vec2 pixel = max(fwidth(vFace), vec2(1e-6));
        vec2 apart = min(vEdges.xz, vEdges.yw);
        vec2 lines = 1.0 - smoothstep(vec2(0.3), vec2(1.25), apart / pixel);
        vec2 fade = 1.0 - smoothstep(vec2(0.1), vec2(0.4), pixel);
        float edge = max(lines.x * fade.x, lines.y * fade.y);
        diffuseColor.rgb *= 1.0 - grid * vLine * edge;`,
      )
      .replace(
        "#include <normal_fragment_begin>",
        `vec3 facing = normalize(vFacing);
        // The edges of a top are worn round, which catches or loses light.
        if (facing.z > 0.5) {
          vec4 worn = (1.0 - smoothstep(0.0, 0.05, vEdges)) * vec4(fade.x, fade.x, fade.y, fade.y);
          facing = normalize(facing + 0.55 * vec3(worn.y - worn.x, worn.w - worn.z, 0.0));
        }
        vec3 normal = normalize(mat3(viewMatrix) * facing);
        #ifdef HAS_OVERLAY
          vec4 over = texture2D(overlay, (vPlace.xy - overlayLow) / overlaySize);
          vec2 inside = step(overlayLow, vPlace.xy) * step(vPlace.xy, overlayLow + overlaySize);
          over.a *= inside.x * inside.y * step(0.5, vFacing.z);
          diffuseColor.rgb = mix(diffuseColor.rgb, over.rgb, over.a);
        #endif`,
      )
      .replace("#include <lights_fragment_end>", shaded("vFacing"));
  };
  return material;
}

/* The floor: smooth concrete with joints at each metre, which fades into the horizon. */
export function floorMaterial(shared: Uniforms): MeshLambertMaterial {
  const material = new MeshLambertMaterial();
  material.onBeforeCompile = (shader) => {
    Object.assign(shader.uniforms, shared);
    shader.vertexShader = shader.vertexShader
      .replace("#include <common>", "#include <common>\nvarying vec3 vPlace;")
      .replace("#include <begin_vertex>", "#include <begin_vertex>\nvPlace = (modelMatrix * vec4(position, 1.0)).xyz;");
    shader.fragmentShader = shader.fragmentShader
      .replace(
        "#include <common>",
        `#include <common>
        uniform vec3 horizon, joint;
        uniform float radius, joints;
        uniform vec2 fades;
        varying vec3 vPlace;
        ${LIT}`,
      )
      .replace(
        "#include <color_fragment>",
        `vec2 tile = vPlace.xy / joints;
        vec2 pixel = max(fwidth(tile), vec2(1e-6));
        vec2 lines = 1.0 - smoothstep(vec2(0.4), vec2(1.3), abs(fract(tile - 0.5) - 0.5) / pixel);
        float line = max(lines.x, lines.y) * (1.0 - smoothstep(0.05, 0.3, max(pixel.x, pixel.y)));
        diffuseColor.rgb = mix(diffuseColor.rgb, joint, 0.4 * line);`,
      )
      .replace("#include <lights_fragment_end>", shaded("vec3(0.0)"))
      .replace(
        "#include <fog_fragment>",
        `float away = length(vPlace.xy) / radius;
        gl_FragColor.rgb = mix(gl_FragColor.rgb, horizon, smoothstep(fades.x, fades.y, away));`,
      );
  };
  return material;
}

/* The sky: from the horizon, where the floor ends, up to the zenith. Its colours are those of the screen. */
export function skyMaterial(shared: Uniforms): ShaderMaterial {
  return new ShaderMaterial({
    uniforms: shared,
    side: BackSide,
    depthWrite: false,
    vertexShader: `varying vec3 vAway;
      void main() {
        vAway = position;
        gl_Position = (projectionMatrix * vec4(mat3(viewMatrix) * position, 1.0)).xyww; // as far as can be
      }`,
    fragmentShader: `uniform vec3 horizon, zenith;
      varying vec3 vAway;
      void main() {
        float up = max(0.0, normalize(vAway).z);
        gl_FragColor = vec4(mix(horizon, zenith, 1.0 - exp(-2.6 * up)), 1.0);
      }`,
  });
}

/* The colours of a screen without a change: as they are written into what is seen. */
export function asWritten(colour: string): Color {
  return new Color(colour).convertLinearToSRGB();
}

export const SUN_AT = new Vector3(...SUN).normalize();
