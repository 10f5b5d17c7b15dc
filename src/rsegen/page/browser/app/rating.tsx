/* A rating while it grows: the share of fields that are crossed, the fitted curve with its band, and a dot for each
   trial, which is driven again and played when it is clicked. */

import { useEffect, useState } from "preact/hooks";
import { Progress } from "./controls";
import { leaveFor } from "./files";
import type { Job, RatedCurve, RatedTrial, RatingSoFar } from "./protocol";
import { call } from "./server";
import { ask, attempt, jobs, list, newest } from "./state";

const [WIDTH, HEIGHT, LEFT, RIGHT, TOP, BOTTOM] = [640, 340, 46, 12, 44, 84];
const COLOURS = ["var(--accent)", "#d9730d", "#2a8c4a", "#8a3ffc"];
const STACK = 6; // dots of one level above each other, before they begin again

/* Where a level and a share are drawn; the curves are over the logarithm of the level, harder fields to the right. */
function scales(rating: RatingSoFar) {
  const place = (level: number) => (rating.is_rising ? 1 : -1) * Math.log(level);
  const ends = rating.curves[0]!.line.map(([level]) => place(level));
  const [low, high] = [Math.min(...ends), Math.max(...ends)];
  return {
    // Single trials far off, as a search begins with, stand at the edge.
    x: (level: number) => LEFT + Math.min(Math.max((place(level) - low) / (high - low), 0), 1) * (WIDTH - LEFT - RIGHT),
    y: (share: number) => HEIGHT - BOTTOM - share * (HEIGHT - TOP - BOTTOM),
  };
}

const path = (points: [number, number][]) => points.map(([x, y], at) => `${at ? "L" : "M"}${x.toFixed(1)},${y.toFixed(1)}`).join("");

/* The rating that a job makes, asked for anew when it has made more trials. */
function useRating(job: Job): RatingSoFar | null {
  const [rating, set] = useState<RatingSoFar | null>(null);
  const [look] = useState(() => newest(async (path: string) => set(await call("rating", { path }))));
  useEffect(() => look(job.output), [job.output, job.done, job.state]);
  return rating;
}

export function RatingCurves({ job }: { job: Job }) {
  const rating = useRating(job);
  const [chosen, choose] = useState<{ judge: string; trial: RatedTrial } | null>(null);
  const [number, follow] = useState<number | null>(null);
  const drive = jobs.value.find((each) => each.id === number);
  const made = drive?.state === "done" ? drive.files.find((file) => file.kind === "drive") : undefined;
  useEffect(() => void (made && leaveFor(made.path)), [made?.path]);
  if (!rating) return job.state === "running" ? <p class="note">The curve appears here after the first trials.</p> : null;
  const again = async (judge: string, trial: RatedTrial) => {
    choose({ judge, trial });
    if (!rating.can_drive) return;
    const started = await attempt(() => ask("drive_trial", { path: job.output, judge, trial: trial.map }));
    if (!started) return;
    list(started);
    follow(started.id);
  };
  const { x, y } = scales(rating);
  return (
    <figure class="rating">
      <svg viewBox={`0 0 ${WIDTH} ${HEIGHT}`} role="group" aria-label={`Share of fields that ${rating.robot} crosses, over the ${rating.axis}`}>
        {[0, 0.5, 0.8, 1].map((share) => <g key={share} class="rule"><line x1={LEFT} x2={WIDTH - RIGHT} y1={y(share)} y2={y(share)} /><text x={LEFT - 6} y={y(share) + 4} text-anchor="end">{100 * share} %</text></g>)}
        {rating.ticks.map((level) => <g key={level} class="rule"><line x1={x(level)} x2={x(level)} y1={y(0)} y2={y(1)} /><text x={x(level)} y={HEIGHT - BOTTOM + 46} text-anchor="middle">{Number(level.toPrecision(3))}</text></g>)}
        <text x={(LEFT + WIDTH - RIGHT) / 2} y={HEIGHT - 18} text-anchor="middle">{rating.axis}</text>
        {rating.curves.map((curve, at) => (
          <g key={curve.judge} style={{ color: COLOURS[at % COLOURS.length]! }}>
            <path class="band" d={`${path(curve.line.map(([level, , low]) => [x(level), y(low)]))}${path([...curve.line].reverse().map(([level, , , high]) => [x(level), y(high)])).replace("M", "L")}Z`} />
            <path class="curve" d={path(curve.line.map(([level, share]) => [x(level), y(share)]))} />
            {curve.points.map(([level, crossed, count]) => <circle key={level} class="share" cx={x(level)} cy={y(crossed / count)} r={2 + Math.sqrt(count)}><title>{`${crossed} of ${count} fields were crossed near ${level.toPrecision(3)}`}</title></circle>)}
            <Dots curve={curve} x={x} y={y} chosen={chosen?.judge === curve.judge ? chosen.trial.map : -1} choose={(trial) => void again(curve.judge, trial)} />
          </g>
        ))}
      </svg>
      <figcaption>
        {rating.curves.map((curve, at) => <p key={curve.judge}><i style={{ background: COLOURS[at % COLOURS.length]! }} />{curve.judge}: {curve.half ? `half of the fields are crossed at ${curve.half}` : "no level found at which half of the fields are crossed"}, {curve.trials.length} trials</p>)}
        <p class="note">{rating.can_drive ? "Each dot is a trial, at the top if the robot crossed. Click a dot to drive it again in MuJoCo and watch." : "Each dot is a trial, at the top if the robot crossed."}</p>
        {chosen && <p role="status">Field {chosen.trial.map} at {chosen.trial.level}: {chosen.trial.crossed === null ? "no result" : chosen.trial.crossed ? "crossed" : "did not cross"}{drive?.state === "running" ? "; driving it again …" : drive?.state === "failed" ? `: ${drive.lines.join(" ")}` : ""}</p>}
        {drive?.state === "running" && <Progress job={drive} />}
      </figcaption>
    </figure>
  );
}

/* A dot for each trial that has a result, those of one level above each other; the arrow keys lead from one to the next. */
function Dots({ curve, x, y, chosen, choose }: { curve: RatedCurve; x: (level: number) => number; y: (share: number) => number; chosen: number; choose: (trial: RatedTrial) => void }) {
  const [focus, set] = useState(0);
  const counts = new Map<string, number>();
  const trials = curve.trials.filter((trial) => trial.crossed !== null);
  const move = (event: KeyboardEvent, at: number, trial: RatedTrial) => {
    if (event.key === "Enter" || event.key === " ") return event.preventDefault(), choose(trial);
    const next = at + (event.key === "ArrowRight" ? 1 : event.key === "ArrowLeft" ? -1 : 0);
    if (next === at || !trials[next]) return;
    event.preventDefault();
    set(next);
    ((event.currentTarget as Element).parentElement?.children[next] as SVGElement | undefined)?.focus();
  };
  return (
    <g class="dots">{trials.map((trial, at) => {
      const place = `${trial.level} ${trial.crossed}`;
      const above = (counts.get(place) ?? 0) % STACK;
      counts.set(place, (counts.get(place) ?? 0) + 1);
      const height = trial.crossed ? y(1) - 9 - 5 * above : y(0) + 9 + 5 * above;
      const what = `field ${trial.map} at ${trial.level}, ${trial.crossed ? "crossed" : "not crossed"}`;
      return (
        <circle key={trial.map} class={`trial${trial.map === chosen ? " chosen" : ""}`} cx={x(trial.level)} cy={height} r={trial.map === chosen ? 5 : 3.2}
          role="button" tabindex={at === focus ? 0 : -1} aria-label={what} onClick={() => choose(trial)} onKeyDown={(event) => move(event, at, trial)}><title>{what}</title></circle>
      );
    })}</g>
  );
}
