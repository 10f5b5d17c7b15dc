/* The robot: which one, where it looks, how it stands, what it reaches, and its best way between two clicks. */

import { signal } from "@preact/signals";
import { useId, useState } from "preact/hooks";
import { Button, Labelled, Segmented, Select, Slider } from "./controls";
import { reasonsOf, scaleOf } from "./overlay";
import type { Calls, DrawnCrossing, DrawnWay, PoseMap } from "./protocol";
import {
  chooseRobot, crossing, dialog, face, heading, hello, mapShown, pose, poseMap, reach, robot, searching, showCrossing, showReach, showTilt, state, stays, stopSearch, tool, way, wayStart,
} from "./state";

/* By what the best way is chosen. */
export const best = signal<NonNullable<Calls["way"]["args"]["best"]>>("safe");

/* Rounded, without the sign of a zero: toFixed writes -0.0. */
const rounded = (number: number, digits: number) => (Number(number.toFixed(digits)) + 0).toFixed(digits);
const degrees = (angle: number) => Number(((angle * 180) / Math.PI).toFixed(1));
const size = (length: number | null) =>
  length === null ? "–" : state.value?.values.units === "in" ? `${rounded(length / 0.0254, 2)} in` : `${rounded(100 * length, 1)} cm`;
const place = ([x, y]: [number, number]) => `${rounded(x, 2)}, ${rounded(y, 2)} m`;

const times = (way: DrawnWay, what: string) => String(way.events.filter(({ text }) => text === what).length);

function Facts({ rows }: { rows: [string, string][] }) {
  return <dl class="facts">{rows.map(([name, value]) => <div key={name}><dt>{name}</dt><dd>{value}</dd></div>)}</dl>;
}

/* What the colours on the map mean. */
function Legend({ map, shown }: { map: PoseMap; shown: "tilt" | "margin" | "reason" }) {
  if (shown === "reason") return <ul class="legend">{reasonsOf(map).map(({ reason, colour }) => <li key={reason} class="key"><i style={{ background: colour }} />{reason || "stands, and can drive on"}</li>)}</ul>;
  const { low, high, colours } = scaleOf(map, shown);
  return (
    <div class="legend">
      <div class="ramp" style={{ background: `linear-gradient(90deg, ${colours.join(", ")})` }} />
      <p><span>{degrees(low)}°</span><span>{shown === "tilt" ? "tilt" : "margin before it tips over"}</span><span>{degrees(high)}°</span></p>
      <p class="key"><i class="hatched" /> does not stand</p>
    </div>
  );
}

const WORDS = { tilt: "Computing how it stands at every place", reach: "Computing where it can drive", crossing: "Predicting whether it gets across", way: "Searching for the best way" };

/* The search that is under way, and a way to stop it. */
function Searching() {
  const now = searching.value;
  if (!now) return null;
  return (
    <div class="searching" role="status">
      <p class="note">{WORDS[now.of]}{now.step && `: ${now.step}`} …</p>
      <progress max={1} value={now.share || undefined} aria-label={WORDS[now.of]} />
      <Button icon="close" class="quiet" title="Stop the search" onClick={stopSearch} />
    </div>
  );
}

const percent = (share: number) => `${Math.round(100 * share)} %`;

/* A prediction: of each side how likely it is, and where and why most of the other drives end. */
function Crossing({ of: { sides, simulator, text } }: { of: DrawnCrossing }) {
  if (!sides.length) return <p class="note">{text}</p>;
  return (
    <>
      {sides.map(({ name, probability, crossed, drives, seconds, ends: [end] }) => (
        <section key={name} aria-label={name}>
          <h3>Crosses {name}</h3>
          <Facts rows={[["probability", percent(probability)], ["drives that cross", `${crossed} of ${drives}`], ...(seconds === null ? [] : [["time to cross", `${rounded(seconds, 1)} s`] as [string, string]])]} />
          {crossed % drives === 0 && <p class="note">{drives} drives cannot prove {percent(crossed / drives)}.</p>}
          {end && <p class="note">{crossed ? "Otherwise it" : "It"} mostly {end.reason} at {place([end.x, end.y])} ({end.drives} of {drives} drives).</p>}
        </section>))}
      <p class="note">Each drive, in {simulator}, has other errors of its start, its position, friction and heights.</p>
      <ul class="legend" aria-label="Lines of drives">
        <li class="key"><i class="line crosses" />a drive that crosses</li>
        <li class="key"><i class="line fails" />a drive that does not; × is where it mostly ends</li>
      </ul>
    </>
  );
}

/* What the colours of the area that it reaches mean, and those of its ways. */
function Reached({ of: { text, ways } }: { of: Calls["reach"]["result"] }) {
  return (
    <>
      <h3>Reach</h3>
      <p>It {text}.</p>
      <ul class="legend" aria-label="Colours of reach">
        {!poseMap.value && <><li class="key"><i class="reached" />full colour: the robot can get there</li><li class="key"><i class="pale" />pale: it cannot</li></>}
        {!crossing.value && <li class="key"><i class={`line ${ways.some(({ crosses }) => crosses) ? "crosses" : "fails"}`} />{ways.some(({ crosses }) => crosses) ? "its way across" : "the way that it tries"}</li>}
      </ul>
    </>
  );
}

const OTHER = " "; // no robot is a blank

/* Which robot: one of rsegen, one of the files in the folder, or another file. */
function Choice() {
  const id = useId();
  const [isOther, takeOther] = useState(false);
  const robots = hello.value?.robots ?? [];
  const isListed = !robot.value || robots.some(({ name }) => name === robot.value);
  const typed = isOther || !isListed;
  const choose = (name: string) => {
    takeOther(name === OTHER);
    if (name !== OTHER) void chooseRobot(name);
  };
  return (
    <Labelled id={id} label="Robot" wide>
      <div class="choice">
        <Select id={id} value={typed ? OTHER : robot.value} onChange={choose}
          choices={[["", "none"], ...robots.map(({ name, title }) => [name, title] as const), [OTHER, "from a file …"]]} />
        {typed && <input type="text" autocomplete="off" aria-label="File of a robot" placeholder="robot.urdf, .sdf, .xacro or .xml" defaultValue={isListed ? "" : robot.value}
          onChange={(event) => void chooseRobot(event.currentTarget.value.trim())} />}
        {typed && <p class="note">SDF, URDF, Xacro or MJCF, in {hello.value?.folder} or a folder in it; then Enter</p>}
      </div>
    </Labelled>
  );
}

export function RobotPanel() {
  const id = useId();
  const turn = (angle: number) => {
    face((angle * Math.PI) / 180);
    if (poseMap.value) void showTilt();
  };
  const stands = pose.value;
  return (
    <section class="panel" aria-label="Robot">
      <h2 class="hidden">Robot</h2>
      <div class="form">
        <Choice />
        {!robot.value && <p class="empty">Choose a robot to see how it stands on the blocks, and where it can drive.</p>}
        {robot.value && <>
          <Labelled id={`${id}-heading`} label="Heading" unit="°" help="Counterclockwise from east (+x). On the map, Shift and the mouse wheel turn the robot" wide>
            <Slider id={`${id}-heading`} name="Heading" value={Math.round(degrees(heading.value))} low={-180} high={180} step={5} whole onChange={(value) => turn(Number(value ?? 0))} />
          </Labelled>
          <div class="actions">
            <Button icon="robot" pressed={tool.value.name === "robot"} title="Show how it stands under the mouse; a click puts it there. Arrow keys move it too; Shift and the wheel, or arrow keys, turn it (R)" onClick={() => { stays.value = false; tool.value = { name: "robot", heading: heading.value }; }}>Place it</Button>
            <Button pressed={Boolean(poseMap.value)} title="Show its tilt at every place, for this heading" onClick={() => (poseMap.value ? (poseMap.value = null) : void showTilt())}>Tilt map</Button>
            <Button pressed={Boolean(reach.value)} title="Show where it can drive, and its ways across the map" onClick={() => (reach.value ? (reach.value = null) : void showReach())}>Reach</Button>
            <Button pressed={Boolean(crossing.value)} title="Predict how likely it is to cross: many drives in MuJoCo, with errors of start, position, friction and heights" onClick={() => (crossing.value ? (crossing.value = null) : void showCrossing())}>Does it cross?</Button>
          </div>
          {poseMap.value && <Segmented name="Shown at each place" value={mapShown.value} choices={[["tilt", "tilt"], ["margin", "margin"], ["reason", "reason"]]} onChange={(next) => (mapShown.value = next)} />}
          {poseMap.value && <Legend map={poseMap.value} shown={mapShown.value} />}
          <Searching />
          <div aria-live="polite">{reach.value && <Reached of={reach.value} />}{crossing.value && <Crossing of={crossing.value} />}</div>
          <div aria-live="polite">{stands && <>
            <h3>Here</h3>
            <p class={`verdict ${stands.reason ? "bad" : "good"}`}>{stands.reason || "stands"}</p>
            {stands.stands && <Facts rows={[["tilt", `${degrees(stands.tilt)}°`], ["margin before it tips over", `${degrees(stands.margin)}°`], ["clearance", size(stands.clearance)],
              ["height", size(stands.z)], ["roll, pitch", `${degrees(stands.roll)}°, ${degrees(stands.pitch)}°`], ["stable poses here", String(stands.stable)]]} />}
            {stands.stands && <Button icon="play" title="Spawn it in a running Gazebo, at this place of the map" onClick={() => (dialog.value = { name: "run", command: "spawn" })}>Spawn in Gazebo …</Button>}</>}
          </div>
          <h3>Best way</h3>
          <Segmented name="Best by" value={best.value} choices={[["safe", "safe"], ["length", "short"], ["tilt", "least tilt"], ["margin", "most margin"]]} onChange={(next) => (best.value = next)} />
          <div class="actions"><Button icon="way" pressed={tool.value.name === "way"} title="Click the start on the map, then the goal; or arrow keys and Enter (W)" onClick={() => (tool.value = { name: "way" })}>Click start and goal</Button></div>
          {wayStart.value && !way.value && searching.value?.of !== "way" && <p class="note" role="status">Now click the goal.</p>}
          <div aria-live="polite">{way.value && (way.value.found
              ? <Facts rows={[["length", `${way.value.length.toFixed(2)} m`], ["largest tilt", `${degrees(way.value.worst_tilt)}°`], ["least margin", `${degrees(way.value.least_margin)}° at ${place(way.value.least_margin_at)}`], ["falls", times(way.value, "falls")], ["slides", times(way.value, "slides")]]} />
              : <p class="note">{way.value.text}</p>)}
          </div>
        </>}
      </div>
    </section>
  );
}
