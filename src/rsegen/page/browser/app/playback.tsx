/* Drives that were recorded, played over the blocks: a time line with play, pause and the events on it. */

import { signal } from "@preact/signals";
import { useEffect } from "preact/hooks";
import { Button, Select } from "./controls";
import type { Playback, RobotShapes } from "./protocol";
import { call } from "./server";
import { attempt, drawing, drawings, forgetRobot, hello, playbacks, played, problem, robot, scene, second } from "./state";

const plays = signal(false);
const speed = signal<"0.25" | "1" | "4">("1");

/* Play a drive; beside it the one that plays already, if asked for. file: of its robot, if it is one of a file. */
export async function play(path: string, beside = false, file = ""): Promise<void> {
  const drive = await attempt(() => call("playback", { path }));
  if (!drive) return;
  // The file of a robot may have changed since it was drawn.
  const isKept = (name: string) => drawings.value.has(name) && hello.value?.robots.some((each) => each.name === name);
  const missing = [...new Set(drive.robots.map((each) => each.robot))].filter((name) => !isKept(name));
  const made = await Promise.all(missing.map((robot) => shapesOf(robot, file)));
  drawings.value = new Map([...drawings.value, ...missing.flatMap((name, at) => (made[at] ? [[name, made[at]] as const] : []))]);
  const unknown = missing.filter((name) => !drawings.value.has(name));
  if (unknown.length) problem.value = { where: "", text: `The file of ${unknown.join(", ")} is not known here: to see the robot drive, choose it under Robot, from a file` };
  if (!beside) played.value = path;
  playbacks.value = beside && playbacks.value.length ? [playbacks.value[0]!, drive] : [drive];
  if (playbacks.value.length === 1) choose(drive);
  second.value = 0;
  plays.value = true;
}

/* Return the drawing of a robot of a drive: of its kind, or of its file if the model in it has that name. */
async function shapesOf(robot: string, file: string): Promise<RobotShapes | null> {
  const get = (name: string) => call("robot", { robot: name }).catch(() => null);
  if (hello.value?.robots.some(({ name }) => name === robot)) return get(robot);
  const drawn = file ? await get(file) : null;
  return drawn?.title === robot ? drawn : null;
}

/* Choose the robot of a drive, which the panel of robots then names and measures; the mouse keeps its tool. */
function choose(drive: Playback): void {
  const isKnown = (kind: string) => drawings.value.has(kind) && hello.value?.robots.some(({ name }) => name === kind);
  const kind = drive.robots.map((each) => each.robot).find(isKnown);
  if (!kind || kind === robot.value) return;
  forgetRobot();
  [robot.value, drawing.value] = [kind, drawings.value.get(kind)!];
}

/* A frame moves the clock by no more than this, in seconds: the first one with a map, and the first one of a page that
   was hidden, come late, and what they skip nobody has seen. */
const LONGEST_FRAME = 0.25;

/* Minutes and seconds, rounded before they are parted: 59.96 s are 1:00.0. */
function clock(seconds: number): string {
  const tenths = Math.round(10 * seconds);
  return `${Math.floor(tenths / 600)}:${((tenths % 600) / 10).toFixed(1).padStart(4, "0")}`;
}

export function Timeline() {
  const shown = playbacks.value;
  const duration = Math.max(0, ...shown.map((drive) => drive.duration));
  const hasMap = scene.value !== null;
  const isOver = duration > 0 && second.value >= duration;
  useEffect(() => {
    if (!plays.value || !duration || !hasMap) return;
    let [last, frame] = [performance.now(), 0];
    const tick = (now: number) => {
      if (!plays.peek()) return; // paused since the last frame
      const passed = Math.min(LONGEST_FRAME, (now - last) / 1000);
      second.value = Math.min(duration, second.value + passed * Number(speed.value));
      last = now;
      if (second.value >= duration) plays.value = false;
      else frame = requestAnimationFrame(tick);
    };
    frame = requestAnimationFrame(tick);
    return () => cancelAnimationFrame(frame);
  }, [plays.value, duration, shown, hasMap]);
  if (!shown.length) return null;
  const events = shown.flatMap((drive) => drive.robots.flatMap((robot) => robot.events.map((each) => ({ ...each, who: robot.name }))));
  const titles = shown.map((drive, at) => (shown.length > 1 ? `${["left", "right"][at]}: ${drive.title}` : drive.title)).join("; ");
  const toggle = () => {
    if (isOver) second.value = 0;
    plays.value = !plays.value;
  };
  return (
    <section class="timeline" aria-label="Drive">
      <Button icon={plays.value ? "pause" : "play"} class="primary" title={plays.value ? "Pause" : isOver ? "Play again from the start" : "Play"} onClick={toggle}>{isOver && "Play again"}</Button>
      <output>{clock(second.value)}</output>
      <div class="track">
        <input type="range" aria-label="Time" min={0} max={duration} step={0.01} value={second.value} style={{ "--part": second.value / (duration || 1) }}
          onInput={(event) => { plays.value = false; second.value = Number(event.currentTarget.value); }} />
        {events.map((event, at) => (
          <button type="button" key={at} class={`event ${event.kind}`} style={{ left: `${(100 * event.second) / (duration || 1)}%` }} title={`${clock(event.second)} ${event.who}: ${event.text}`}
            aria-label={`${clock(event.second)} ${event.who}: ${event.text}`} onClick={() => { plays.value = false; second.value = event.second; }} />
        ))}
      </div>
      <output>{clock(duration)}</output>
      <Select name="Speed" value={speed.value} choices={[["0.25", "¼ ×"], ["1", "1 ×"], ["4", "4 ×"]]} onChange={(next) => (speed.value = next)} />
      <span class="name" role="status">{hasMap ? titles : "waiting for the map …"}</span>
      <Button icon="close" class="quiet" title="Close the playback" onClick={() => { plays.value = false; playbacks.value = []; }} />
    </section>
  );
}
