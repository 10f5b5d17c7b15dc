/* The robot: which one, where it looks, how it stands, what it reaches, and its best way between two clicks. */

import { signal } from "@preact/signals";
import { useId } from "preact/hooks";
import { Button, Labelled, Segmented, Select, Slider } from "./controls";
import {
  chooseRobot, heading, hello, mapShown, pose, poseMap, reach, robot, settle, showReach, showTilt, tool, way, wayStart,
} from "./state";

/* By what the best way is chosen. */
export const best = signal<"length" | "tilt" | "margin">("length");

const degrees = (angle: number) => Number(((angle * 180) / Math.PI).toFixed(1));
const centimetres = (length: number | null) => (length === null ? "–" : `${(100 * length).toFixed(1)} cm`);

function Facts({ rows }: { rows: [string, string][] }) {
  return <dl class="facts">{rows.map(([name, value]) => <div key={name}><dt>{name}</dt><dd>{value}</dd></div>)}</dl>;
}

export function RobotPanel() {
  const id = useId();
  const robots = hello.value?.robots ?? [];
  const turn = (angle: number) => {
    heading.value = (angle * Math.PI) / 180;
    if (tool.value.name === "robot") tool.value = { name: "robot", heading: heading.value };
    if (pose.value) settle(pose.value.x, pose.value.y);
    if (poseMap.value) void showTilt();
  };
  const stands = pose.value;
  return (
    <section class="panel" aria-label="Robot">
      <h2 class="hidden">Robot</h2>
      <div class="form">
        <Labelled id={`${id}-robot`} label="Robot" wide>
          <Select id={`${id}-robot`} value={robot.value} onChange={(name) => void chooseRobot(name)}
            choices={[["", "none"], ...robots.map((each) => [each.name, each.title] as const)]} />
        </Labelled>
        {!robot.value && <p class="empty">Choose a robot: it settles on the blocks under the mouse, and shows where it can drive.</p>}
        {robot.value && <>
          <Labelled id={`${id}-heading`} label="Heading" unit="°" help="Counterclockwise from the east (+x)" wide>
            <Slider id={`${id}-heading`} name="Heading" value={Math.round(degrees(heading.value))} low={-180} high={180} step={5} whole onChange={(value) => turn(Number(value ?? 0))} />
          </Labelled>
          <div class="actions">
            <Button icon="robot" pressed={tool.value.name === "robot"} title="It settles where the mouse is; a click puts it there (R)" onClick={() => (tool.value = { name: "robot", heading: heading.value })}>Place it</Button>
            <Button pressed={Boolean(poseMap.value)} title="Its tilt at every place, for this heading" onClick={() => (poseMap.value ? (poseMap.value = null) : void showTilt())}>Tilt map</Button>
            <Button pressed={Boolean(reach.value)} title="Where it gets to, and its ways across" onClick={() => (reach.value ? (reach.value = null) : void showReach())}>Reach</Button>
          </div>
          {poseMap.value && <Segmented name="Shown at each place" value={mapShown.value} choices={[["tilt", "tilt"], ["margin", "margin"], ["reason", "why not"]]} onChange={(next) => (mapShown.value = next)} />}
          {reach.value && <p class="note">{reach.value.text}</p>}
          {stands && <div aria-live="polite">
            <h3 class={stands.stands && stands.holds ? "good" : "bad"}>{stands.reason || "stands"}</h3>
            {stands.stands && <Facts rows={[["tilt", `${degrees(stands.tilt)}°`], ["margin to tipping over", `${degrees(stands.margin)}°`], ["clearance", centimetres(stands.clearance)],
              ["height", centimetres(stands.z)], ["roll, pitch", `${degrees(stands.roll)}°, ${degrees(stands.pitch)}°`], ["contacts", String(stands.contacts.length)]]} />}
          </div>}
          <h3>Best way</h3>
          <Segmented name="Best by" value={best.value} choices={[["length", "shortest"], ["tilt", "least tilt"], ["margin", "safest"]]} onChange={(next) => (best.value = next)} />
          <div class="actions"><Button icon="way" pressed={tool.value.name === "way"} title="Two clicks on the map: start and goal (W)" onClick={() => (tool.value = { name: "way" })}>Click start and goal</Button></div>
          {wayStart.value && !way.value && <p class="note" role="status">Now click the goal.</p>}
          {way.value && <div aria-live="polite"><p class="note">{way.value.text}</p>
            {way.value.found && <Facts rows={[["length", `${way.value.length.toFixed(2)} m`], ["largest tilt", `${degrees(way.value.worst_tilt)}°`],
              ["least margin", `${degrees(way.value.least_margin)}°`], ["drops and slips", String(way.value.events.length)]]} />}</div>}
        </>}
      </div>
    </section>
  );
}
