/* The parameters of the whole map, and which of the recipe's maps is shown. */

import { signal } from "@preact/signals";
import { Button } from "./controls";
import { Form } from "./fields";
import { leaveFor } from "./files";
import type { Field, Json } from "./protocol";
import { dialog, edit, hello, index, problemAt, scene, showMap, state } from "./state";
import { Difficulty } from "./results";

export function MapPanel() {
  const [now, groups] = [state.value, hello.value?.globals ?? []];
  if (!now || !groups.length) return <section class="panel" aria-label="Map"><p class="empty">Loading …</p></section>;
  const basic = groups.flatMap((group) => group.fields.filter((field) => field.basic));
  const others = groups
    .map((group) => ({ ...group, fields: group.fields.filter((field) => !field.basic && field.name !== "difficulty" && field.name !== "seed") }))
    .filter((group) => group.fields.length);
  const change = (name: string, value: Json | undefined, gesture: string) =>
    void edit({ do: "set", name, value: value ?? null, gesture: gesture || undefined });
  const all = groups.flatMap((group) => group.fields);
  const isFound = (field: Field) => `${field.title} ${field.name} ${field.help}`.toLowerCase().includes(wanted.value.trim().toLowerCase());
  return (
    <section class="panel" aria-label="Map">
      <Form fields={basic} values={now.values} problems={problemAt} onChange={change} />
      <Difficulty />
      <div class="actions">
        <Button title="Compare 12 other seeds, and choose one" onClick={() => (dialog.value = { name: "variants" })}>Show 12 variants</Button>
        <Button class="primary" title="Write worlds and models (Ctrl+Enter)" onClick={() => (dialog.value = { name: "run", command: "generate" })}>Generate …</Button>
      </div>
      <input type="search" class="filter" aria-label="Find a parameter" placeholder="Find a parameter" value={wanted.value}
        onInput={(event) => (wanted.value = event.currentTarget.value)} />
      {wanted.value.trim() ? (all.some(isFound)
        ? <Form fields={all.filter(isFound).map((field) => ({ ...field, basic: true }))} values={now.values} problems={problemAt} onChange={change} explained />
        : <p class="empty">No parameter has “{wanted.value.trim()}” in its name or help.</p>) : others.map((group) => (
        <details key={group.title} open={group.fields.some((field) => problemAt(field.name)) || undefined}>
          <summary>{group.title}</summary>
          <Form fields={group.fields} values={now.values} problems={problemAt} onChange={change} />
        </details>
      ))}
    </section>
  );
}

/* What parameters are filtered by. */
const wanted = signal("");

/* Steps through the maps of the recipe, or of the data set that it is from; people count from 1, names of maps from 0. */
export function MapChooser() {
  const now = state.value;
  if (!now) return null;
  if (now.data_set) {
    const { folder, place, maps } = now.data_set;
    return <Stepper of="the data set" place={place} maps={maps} name={`${folder}#${place}`} go={(next) => void leaveFor(`${folder}#${next}`)} />;
  }
  const first = now.first_map ?? 0;
  if (now.maps < 2) return null;
  return <Stepper of="the recipe" place={index.value - first} maps={now.maps} name={scene.value?.name ?? now.name} go={(next) => void showMap(first + next)} />;
}

function Stepper({ of, place, maps, name, go }: { of: string; place: number; maps: number; name: string; go: (place: number) => void }) {
  return (
    <div class="chooser" role="group" aria-label={`Map of ${of}`}>
      <Button icon="left" class="quiet" title={`Previous map of ${of}`} disabled={place <= 0} onClick={() => go(place - 1)} />
      <output aria-live="polite" title={name}>Map {place + 1} of {maps}</output>
      <Button icon="right" class="quiet" title={`Next map of ${of}`} disabled={place >= maps - 1} onClick={() => go(place + 1)} />
    </div>
  );
}
