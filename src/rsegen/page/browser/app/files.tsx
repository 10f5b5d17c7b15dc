/* Opening, saving, what to do about a file that somebody else changed, and files that are dropped on the page. */

import { signal } from "@preact/signals";
import { useEffect, useId, useState } from "preact/hooks";
import { Button, Icon, Modal } from "./controls";
import { play } from "./playback";
import { Picture } from "./results";
import type { Calls, ListedFile, Listing } from "./protocol";
import { SILENT, call, upload } from "./server";
import { attempt, busy, dialog, hello, lost, open, playbacks, problem, reload, save, state } from "./state";

const ICONS = { recipe: "file", folder: "folder", dataset: "folder", drive: "play", other: "file" } as const;

const close = () => (dialog.value = null);

/* The examples as they are drawn small, once the list has been opened. */
const examples = signal<Calls["example_maps"]["result"]>({});

async function drawExamples(): Promise<void> {
  if (!Object.keys(examples.value).length) examples.value = (await attempt(() => call("example_maps", {}), false)) ?? {};
}

/* Open what a folder lists: a drive is played over its map, or beside the one that is played. */
async function openEntry({ path, kind }: ListedFile): Promise<void> {
  if (kind === "drive" && playbacks.value.length) return close(), play(path, true);
  await leaveFor(kind === "dataset" ? `${path}#0` : path);
}

/* Open another recipe, after a question if the one that is open would be left unsaved; false if it was not opened. */
export async function leaveFor(what: string): Promise<boolean> {
  if (state.value?.unsaved && !confirm(`${state.value.title} has unsaved changes. Discard them?`)) return false;
  const opened = await open(what);
  if (!opened) return false;
  dialog.value = null;
  if (opened.play) await play(opened.play);
  return true;
}

export function Open() {
  const [folder, go] = useState<string | undefined>(undefined);
  const [listing, list] = useState<Listing | null>(null);
  const id = useId();
  const [path, setPath] = useState("");
  useEffect(() => void attempt(() => call("files", folder === undefined ? {} : { folder }), false).then(list), [folder]);
  useEffect(() => void drawExamples(), []);
  return (
    <Modal title="Open" close={close} wide>
      <div class="columns">
        <section aria-labelledby={`${id}-examples`}>
          <h3 id={`${id}-examples`}>Examples</h3>
          <ul class="choices">{hello.value?.examples.map((each) => (
            <li key={each.name}><button type="button" class="pictured" onClick={() => void leaveFor(each.name)}>
              {examples.value[each.name] ? <Picture map={examples.value[each.name]!} label="" /> : <span class="placeholder" />}
              <span><b>{each.name}</b><small>{each.description}</small></span></button></li>))}</ul>
        </section>
        <section aria-labelledby={`${id}-files`}>
          <h3 id={`${id}-files`}>Files in {listing?.folder || hello.value?.folder}</h3>
          {folder && <Button icon="left" class="quiet" title="Parent folder" onClick={() => go(folder.includes("/") ? folder.replace(/\/[^/]*$/, "") : undefined)}>parent folder</Button>}
          <ul class="choices">{listing?.entries.map((each) => (
            <li key={each.path}><button type="button" disabled={each.kind === "other"} onClick={() => (each.kind === "folder" ? go(each.path) : void openEntry(each))}>
              <span><Icon name={ICONS[each.kind]} /> {each.name}</span>{each.kind === "dataset" && <small>data set</small>}{each.kind === "drive" && <small>{playbacks.value.length ? "recorded drive: plays next to the other one" : "recorded drive: plays on its map"}</small>}</button></li>))}</ul>
          {listing && !listing.entries.length && <p class="empty">No recipes in this folder yet.</p>}
          <form class="actions" onSubmit={(event) => { event.preventDefault(); void leaveFor(path); }}>
            <input type="text" aria-label="Path of a recipe, or DIR#17 for map 17 of a data set" placeholder="path of a recipe, or DIR#17" value={path} onInput={(event) => setPath(event.currentTarget.value)} />
            <button type="submit" disabled={!path}>Open</button>
          </form>
        </section>
      </div>
      {problem.value && <p class="problem" role="alert">{problem.value.text}</p>}
    </Modal>
  );
}

export function SaveAs() {
  const id = useId();
  const [path, setPath] = useState(state.value?.path ?? `${state.value?.name || "my-map"}.yaml`);
  const question = problem.value?.kind;
  useEffect(() => void (problem.value = null), []);
  const write = async (event: Event) => {
    event.preventDefault();
    if (await save(path, question === "exists" || question === "changed")) close();
  };
  return (
    <Modal title="Save as" close={close}>
      <form onSubmit={write}>
        <div class="field tall"><label for={id}>File in {hello.value?.folder}</label>
          <div class="control"><input id={id} type="text" value={path} onInput={(event) => { problem.value = null; setPath(event.currentTarget.value); }} /></div>
          <p class="note">The name ends in .yaml or .json, and the maps get it too.</p>
          {problem.value && <p class="problem" role="alert">{problem.value.text}</p>}</div>
        <footer class="actions"><button type="button" onClick={close}>Cancel</button>
          <button type="submit" class="primary" disabled={!path || busy.value > 0}>{question === "exists" ? "Replace the file" : question === "changed" ? "Overwrite the other changes" : "Save"}</button></footer>
      </form>
    </Modal>
  );
}

/* A time of the server as people here write it. */
function when(text: string): string {
  const time = new Date(text);
  return Number.isNaN(time.valueOf()) ? text : time.toLocaleString();
}

/* What somebody has to decide before going on. */
export function Banners() {
  const now = state.value;
  const [kept, keep] = useState<number | null>(null);
  const [seen, see] = useState<string | null>(null);
  const [hidden, hide] = useState("");
  if (!now) return null;
  const unsafe = [hello.value?.read_only, now.journal].filter(Boolean).join("; ");
  const isAsked = problem.value?.kind === "changed" && dialog.value?.name !== "save"; // as it was about to be overwritten
  const isChanged = isAsked || (now.changed_on_disk && kept !== now.revision);
  return (
    <div class="banners" aria-live="polite">
      {lost.value && (
        <div class="banner"><Icon name="warn" /><p>{lost.value !== SILENT ? lost.value : <><b>rsegen gui</b> does not answer: it was stopped, or the connection is lost.
          {now.unsaved ? " Your unsaved changes are kept: start" : " Start"} it again in the same folder. If this page does not go on by itself, open the address that it prints.</>}</p></div>)}
      {unsafe.length > 0 && hidden !== unsafe && (
        <div class="banner"><Icon name="warn" /><p>{unsafe}</p>
          <Button icon="close" class="quiet" title="Dismiss" onClick={() => hide(unsafe)} /></div>)}
      {isChanged && (
        <div class="banner"><Icon name="warn" /><p>Another program changed <b>{now.title}</b>.</p>
          <button type="button" onClick={() => void save(undefined, true)}>Keep my version</button>
          <button type="button" onClick={() => void reload()}>Load the changed file</button>
          <Button icon="close" class="quiet" title="Decide later" onClick={() => { keep(now.revision); problem.value = null; }} /></div>)}
      {now.file_is_gone && (
        <div class="banner"><Icon name="warn" /><p>Another program removed or renamed <b>{now.title}</b>.</p>
          <button type="button" onClick={() => void save()}>Save it again</button></div>)}
      {now.recovered && seen !== now.doc && (
        <div class="banner"><Icon name="warn" /><p>Unsaved changes from an earlier session were restored. You made them on {when(now.recovered)}.</p>
          <button type="button" onClick={() => see(now.doc)}>Keep them</button>
          <button type="button" onClick={() => { see(now.doc); void reload(); }}>Discard them</button></div>)}
    </div>
  );
}

/* The command for a dropped file, by the suffixes that its help lists: "files: *.ply, *.las"; a table may be either's. */
function commandFor(name: string): string | null {
  const suffix = `*${/\.\w+$/.exec(name)?.[0].toLowerCase() ?? ""}`;
  const reads = (command: string) => hello.value?.commands.find((each) => each.name === command)?.fields
    .some(({ help, required }) => required && help.split(/[\s,]+/).includes(suffix));
  return ["import", "scan"].find(reads) ?? null;
}

/* Take files that are dropped on the page: recipes are opened, measured fields become the form of their command. */
export async function dropped(file: File): Promise<void> {
  const path = await attempt(() => upload(file));
  if (path === null) return;
  const command = commandFor(file.name);
  if (/\.(ya?ml|json)$/i.test(file.name)) await leaveFor(path);
  else if (command) dialog.value = { name: "run", command, upload: path };
  else problem.value = { where: "", text: `${file.name}: not a recipe, a point cloud, or a table or image of heights` };
}
