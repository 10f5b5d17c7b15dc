/* The parameters of the whole map, and which of the recipe's maps is shown. */

import { signal } from "@preact/signals";
import { Button } from "./controls";
import { Form } from "./fields";
import type { Field, Json } from "./protocol";
import { leaveFor } from "./run";
import { dialog, edit, hello, index, problemAt, showMap, state } from "./state";
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
        <Button title="Twelve other seeds as pictures; keep one" onClick={() => (dialog.value = { name: "variants" })}>Show twelve …</Button>
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

/* Steps through the maps of the recipe, or of the data set that it is from. */
export function MapChooser() {
  const now = state.value;
  const [, data, number] = /^(.+)#(\d+)$/.exec(now?.path ? "" : (now?.title ?? "")) ?? [];
  if (data) {
    const at = Number(number);
    return (
      <div class="chooser" role="group" aria-label="Map of the data set">
        <Button icon="left" class="quiet" title="Previous map of the data set" disabled={at === 0} onClick={() => void leaveFor(`${data}#${at - 1}`)} />
        <output aria-live="polite">map {at} <small>of {data}</small></output>
        <Button icon="right" class="quiet" title="Next map of the data set" onClick={() => void leaveFor(`${data}#${at + 1}`)} />
      </div>
    );
  }
  if (!now || now.maps < 2) return null;
  const first = now.first_map ?? 0;
  return (
    <div class="chooser" role="group" aria-label="Map of the recipe">
      <Button icon="left" class="quiet" title="Previous map" disabled={index.value <= first} onClick={() => void showMap(index.value - 1)} />
      <output aria-live="polite">map {index.value} <small>of {first} to {first + now.maps - 1}</small></output>
      <Button icon="right" class="quiet" title="Next map" disabled={index.value >= first + now.maps - 1} onClick={() => void showMap(index.value + 1)} />
    </div>
  );
}
