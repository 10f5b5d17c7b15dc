/* What the map is: its heights, metrics and costs, its recipe as text; and other maps like it. */

import { useEffect, useId, useState } from "preact/hooks";
import { Button, Modal, Segmented, Select, Slider, useAddress } from "./controls";
import { FieldControl } from "./fields";
import type { SceneData, Texts, Variant } from "./protocol";
import { Failed } from "./server";
import { thumbnail } from "./solid";
import { ask, attempt, counted, dark, dialog, edit, frozen, hello, measure, nameOf, newGesture, problem, problemAt, results, robot, say, scene, showMap, state } from "./state";

export function Heights({ map }: { map: SceneData }) {
  const most = Math.max(1, ...map.palette.map((each) => each.count));
  return (
    <table class="heights">
      <caption class="hidden">Heights of the map</caption>
      <thead class="hidden"><tr><th scope="col">level</th><th scope="col">height</th><th scope="col">blocks</th><th scope="col">share</th></tr></thead>
      <tbody>
        {[...map.palette].reverse().map((each) => (
          <tr key={each.level ?? "frame"}>
            <th scope="row"><i style={{ background: each.colour }} />{each.level === null ? "frame" : `level ${each.level}`}</th>
            <td>{each.label} {map.unit}</td>
            <td>{each.count.toLocaleString("en").replaceAll(",", "\u2009")}</td>
            <td class="bar"><span style={{ width: `${(100 * each.count) / most}%` }} /></td>
          </tr>
        ))}
      </tbody>
    </table>
  );
}

/* Metrics; old ones, of a map that is not shown any more, are pale. */
function Table({ rows, title, isOld }: { rows: [string, string, string, ...unknown[]][]; title: string; isOld: boolean }) {
  return (
    <table class="metrics" aria-busy={isOld}><caption class="hidden">{title}</caption><tbody>
      {rows.map(([name, value, meaning]) => <tr key={name}><th scope="row">{name}<small>{meaning}</small></th><td>{value}</td></tr>)}
    </tbody></table>
  );
}

type Measured = { of: string; rows: [string, string, string, string][] };

let latest: Measured | null = null;

export function Results() {
  const map = scene.value;
  useEffect(() => void (map && !frozen && measure()), [map]);
  if (!map) return <section class="panel" aria-label="Results"><p class="empty">No map yet.</p></section>;
  const { metrics, constraints, cost } = { ...map, ...results.value };
  const isOld = Boolean(results.value) && results.value?.of !== nameOf(map); // those of the map before, until this one is measured
  const facts = [...map.facts, ...(cost ? [["in Gazebo", cost] as const] : [])];
  return (
    <section class="panel" aria-label="Results">
      <h2 class="hidden">Results</h2>
      {map.warnings?.map(counted).map((warning) => <p class="problem" key={warning}>{warning}</p>)}
      {constraints?.length ? <><h3>Constraints</h3><ul class="lines" aria-busy={isOld}>{constraints.map((line) => <li key={line}>{line}</li>)}</ul></> : null}
      <h3>Heights</h3>
      <Heights map={map} />
      <h3>Metrics</h3>
      {metrics ? <Table rows={metrics} title="Metrics of the map" isOld={isOld} /> : <p class="empty">Measuring …</p>}
      {!frozen && <AllMetrics map={map} />}
      <h3>Recipe</h3>
      <Recipe map={map} />
      {facts.length > 0 && <><h3>Facts</h3><dl class="facts">{facts.map(([name, value]) => <div key={name} aria-busy={isOld && value === cost}><dt>{name}</dt><dd>{value}</dd></div>)}</dl></>}
    </section>
  );
}

/* All metrics, which take a moment: measured when they are asked for. */
function AllMetrics({ map }: { map: SceneData }) {
  const key = `${nameOf(map)} ${robot.value}`;
  const [open, setOpen] = useState(false);
  const [measured, set] = useState(latest?.of === key ? latest : null);
  const [failure, fail] = useState("");
  useEffect(() => {
    if (!open) return;
    let wanted = true;
    fail("");
    void ask("measure", { index: map.index ?? 0, ...(robot.value && { robot: robot.value }) }).then((found) => {
      latest = { of: key, rows: found.rows };
      if (wanted) set(latest);
    }, (error: unknown) => {
      if (!(error instanceof Failed)) throw error;
      if (!wanted) return;
      set(null);
      fail(error.message);
    });
    return () => void (wanted = false);
  }, [open, key]);
  return (
    <details onToggle={(event) => setOpen(event.currentTarget.open)}>
      <summary>All metrics{robot.value && `, also those of ${robot.value}`}</summary>
      {measured ? <Table rows={measured.rows} title="All metrics" isOld={measured.of !== key} />
        : failure ? <p class="problem" role="alert">{failure}</p> : <p class="empty">Measuring …</p>}
    </details>
  );
}

/* ---- the recipe as text */

function Recipe({ map }: { map: SceneData }) {
  const [shown, show] = useState<keyof Texts>("recipe");
  const [texts, setTexts] = useState<Texts | null>(null);
  const revision = state.value?.revision;
  useEffect(() => {
    if (!frozen) void attempt(() => ask("texts", {}), false).then((found) => found && setTexts(found));
  }, [revision]);
  const text = frozen ? map.recipe : (texts?.[shown] ?? map.recipe);
  if (!text) return <p class="empty">This map has no recipe.</p>;
  const suffix = { recipe: "", python: ".py", shell: ".sh" }[shown];
  const file = suffix ? map.file.replace(/\.\w+$/, suffix) : map.file;
  return (
    <>
      <div class="actions">
        {!frozen && <Segmented name="Recipe as" value={shown} choices={[["recipe", "YAML"], ["python", "Python"], ["shell", "shell"]]} onChange={show} />}
        <Button icon="copy" title="Copy the text" class="quiet" onClick={() => void copy(text)} />
        <a class="button quiet" download={file} href={`data:text/plain;charset=utf-8,${encodeURIComponent(text)}`}>Download</a>
      </div>
      <pre tabindex={0} role="group" aria-label="Recipe">{text}</pre>
      {frozen && <p class="note">To make this map again: <code>rsegen generate {map.file} -o worlds</code></p>}
    </>
  );
}

/* Copy a text, and say whether that was possible. */
export async function copy(text: string): Promise<void> {
  // A page of another machine that came over plain HTTP has no clipboard, but may copy a selection.
  const copied = navigator.clipboard ? await navigator.clipboard.writeText(text).then(() => true, () => false) : false;
  say(copied || copySelection(text) ? "Copied" : "Your browser does not let this page copy; select the text, and copy it");
}

function copySelection(text: string): boolean {
  const [before, area] = [document.activeElement, Object.assign(document.createElement("textarea"), { value: text })];
  (document.querySelector("dialog[open]") ?? document.body).append(area); // nothing outside of an open dialog is selected
  area.select();
  const copied = document.execCommand("copy");
  area.remove();
  if (before instanceof HTMLElement) before.focus();
  return copied;
}

/* ---- difficulty, and other seeds */

export function Difficulty() {
  const id = useId();
  const field = hello.value?.globals.flatMap((group) => group.fields).find((each) => each.name === "difficulty");
  const value = state.value?.values.difficulty;
  if (!field) return null;
  const set = (next: unknown, gesture: string) => void edit({ do: "set", name: "difficulty", value: (next ?? null) as number | null, gesture });
  if (Array.isArray(value))
    return <FieldControl field={field} value={value} problem={problemAt("difficulty")} onChange={set} />;
  return (
    <div class="field tall" data-field="Difficulty">
      <label for={id} title={field.help}>Difficulty <small>1 as designed, 0 flat</small></label>
      <div class="control">
        <Slider id={id} name="Difficulty" value={value ?? undefined} placeholder="off" empty low={0} high={1} step={0.01} whole={false} problem={problemAt("difficulty")} onChange={set} />
      </div>
      {problemAt("difficulty") && <p class="problem" role="alert">{problemAt("difficulty")}</p>}
      {value === undefined || value === null ? null : <Button class="quiet link" title="Set a range: each map gets a random difficulty from it" onClick={() => set([0, value], newGesture())}>a range …</Button>}
    </div>
  );
}

/* A small picture of a map in 3D; one without a label stands beside its name. */
export function Picture({ map, label }: { map: SceneData; label: string }) {
  const source = useAddress(() => thumbnail(map, 256, 176, dark.value), [map, dark.value]);
  return source ? <img src={source} alt={label} width={256} height={176} /> : <span class="placeholder" role={label ? "img" : undefined} aria-label={label || undefined} />;
}

const MOST_SORTED = 200; // maps, by the server

/* Twelve other seeds of the recipe, or its own maps, as pictures. */
export function Variants() {
  const [of, choose] = useState<"seeds" | "maps">("seeds");
  const [from, setFrom] = useState(0); // the place of the first picture in the order of the maps
  const [by, sort] = useState("");
  const [found, setFound] = useState<Variant[] | null>(null);
  const close = () => (dialog.value = null);
  const look = async () => {
    setFound(null);
    setFound((await attempt(() => (of === "seeds" ? ask("variants", { count: 12 }) : ask("maps", { first: from, count: 12, by })))) ?? []);
  };
  useEffect(() => void look(), [of, from, by]);
  const keep = (variant: Variant) => {
    if (of === "seeds") void edit({ do: "set", name: "seed", value: variant.seed });
    else void showMap(variant.index);
    close();
  };
  const orders = [["", "by number"] as const, ...(hello.value?.metrics ?? []).map(({ name, title }) => [name, `by ${title}`] as const)];
  const [maps, first] = [state.value?.maps ?? 1, state.value?.first_map ?? 0];
  const count = by ? Math.min(maps, MOST_SORTED) : maps;
  return (
    <Modal title="Variants" close={close} wide>
      <div class="actions">
        <Segmented name="Of" value={of} choices={[["seeds", "other seeds"], ["maps", "maps of this recipe"]]} onChange={choose} />
        {of === "seeds" ? <Button icon="dice" title="Draw 12 other seeds" onClick={() => void look()}>12 others</Button> : <>
          <Button icon="left" title="Previous 12" disabled={from <= 0} onClick={() => setFrom(Math.max(0, from - 12))} />
          <Button icon="right" title="Next 12" disabled={from + 12 >= count} onClick={() => setFrom(from + 12)} />
          <Select name="Sorted by" value={by} choices={orders} onChange={(next) => { sort(next); setFrom(0); }} />
          {by && <span class="note">the lowest first{maps > MOST_SORTED && `; ${MOST_SORTED} of ${maps} maps, evenly spaced`}</span>}</>}
      </div>
      <ul class="gallery">
        {(found ?? []).map((variant) => (
          <li key={`${variant.seed}-${variant.index}`}>
            <button type="button" class="card" onClick={() => keep(variant)} title={of === "seeds" ? `Use seed ${variant.seed}` : `Show map ${variant.index - first + 1}`}>
              <Picture map={variant.scene} label={of === "seeds" ? `seed ${variant.seed}` : `map ${variant.index - first + 1}`} />
              <span class="name">{of === "seeds" ? String(variant.seed) : `Map ${variant.index - first + 1}`}</span>
              <dl>{variant.difficulty.map(([name, value]) => <div key={name}><dt>{name}</dt><dd>{value}</dd></div>)}</dl>
            </button>
          </li>
        ))}
      </ul>
      {problem.value && <p class="problem" role="alert">{problem.value.text}</p>}
      {found === null && <p class="empty" role="status">Drawing 12 maps …</p>}
    </Modal>
  );
}

