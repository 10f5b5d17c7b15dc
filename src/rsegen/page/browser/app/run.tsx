/* Commands as dialogs: a form, the same line for a shell, run; then progress, report and files. */

import { useEffect, useId, useRef, useState } from "preact/hooks";
import { Button, Icon, Labelled, Modal, Progress, useAddress } from "./controls";
import { shown } from "./exact";
import { Form } from "./fields";
import { leaveFor } from "./files";
import { play } from "./playback";
import type { DescribedCommand, Field, Job, Json, SceneData } from "./protocol";
import { call, fileOf, Failed, manual } from "./server";
import { ask, attempt, dialog, heading, hello, index, jobs, list, playbacks, put, robot, state, told, unreadIn } from "./state";
import { RatingCurves } from "./rating";
import { Picture, copy } from "./results";

/* What a command is called in menus. */
export const titleOf = (name: string): string => hello.value?.commands.find((command) => command.name === name)?.title ?? name;

type Values = { [name: string]: Json | undefined };

const OUTPUTS: { [command: string]: string } = {
  generate: "worlds", drive: "drives", experiment: "experiment", export: "export", scan: "scans", import: "worlds", dataset: "dataset", series: "series", terrain: "terrain", spawn: "worlds", respawn: "worlds",
};

const SUFFIXES: { [command: string]: string } = { view: "html", preview: "png" };

/* What was chosen last for each command, until the page is left. */
const remembered = new Map<string, { values: Values; output: string }>();

const mapName = (at: number) => `${state.value!.name}_${String(at).padStart(4, "0")}`;

const MOST_NAMED = 500; // maps in a list to choose from

/* The fields of a form: of several maps one is chosen by its name, of a single one nothing is to be said. */
function fieldsOf(command: DescribedCommand, target: string): Field[] {
  if (target) return command.fields.filter((field) => field.name !== "map");
  const { maps = 1, first_map: first = 0 } = state.value ?? {};
  if (command.target !== "recipe" || maps > MOST_NAMED) return command.fields;
  const names = Array.from({ length: maps }, (_, at) => mapName(first + at));
  return command.fields.flatMap((field) => (field.name !== "map" ? [field] : maps === 1 ? [] : [{ ...field, schema: { enum: names } }]));
}

function usual(command: DescribedCommand, upload?: string, target?: string): { values: Values; output: string } {
  const file = command.output_required ? `${state.value?.name}.${SUFFIXES[command.name] ?? "pdf"}` : "";
  const known = remembered.get(command.name) ?? { values: {}, output: OUTPUTS[command.name] ?? (command.output === "file" ? file : command.name) };
  const values: Values = { ...known.values };
  const input = command.fields.find((field) => field.required && /cloud|file|path/.test(field.name));
  if (upload && input) values[input.name] = input.schema.type === "array" ? [upload] : upload;
  // The map that is shown is meant by what is about one map.
  const one = command.fields.find((field) => field.name === "map" && !field.help.includes("all"));
  delete values.map;
  if (one && !target && (state.value?.maps ?? 1) > 1) values.map = mapName(index.value);
  if (robot.value && command.fields.some((field) => field.name === "robot")) values.robot ??= robot.value;
  if (robot.value && put.value && command.name === "spawn") values.pose = [...put.value, heading.value].map((value) => Number(value.toFixed(4)));
  return { values, output: command.output === "none" ? "" : known.output };
}

const isEmpty = (value: Json | undefined) => value === undefined || value === null || value === "" || (Array.isArray(value) && !value.length);

export function Run({ name, upload, target = "" }: { name: string; upload?: string; target?: string }) {
  const command = hello.value?.commands.find((each) => each.name === name);
  const id = useId();
  const [{ values, output }, set] = useState(() => (command ? usual(command, upload, target) : { values: {}, output: "" }));
  const [line, setLine] = useState({ text: "", why: "…" }); // what does the same in a shell, or why there is none yet
  const asked = () => ({
    command: name, values: Object.fromEntries(Object.entries(values).filter((entry): entry is [string, Json] => entry[1] !== undefined)), ...(output && { output }), ...(target && { target }),
  });
  useEffect(() => {
    let wanted = true;
    void ask("shell_line", asked()).then((found) => wanted && setLine(found), (error: unknown) => {
      if (!(error instanceof Failed)) throw error;
    });
    return () => void (wanted = false);
  }, [values, output]);
  const [failure, fail] = useState<Failed["failure"] | null>(null);
  // What may be replaced is what was asked about, and nothing that is named after the question.
  const change: typeof set = (to) => { set(to); fail((now) => (now?.kind ? null : now)); };
  const [number, follow] = useState<number | null>(null);
  const close = () => (dialog.value = null);
  const takesRecipe = command?.target === "recipe" && !target;
  if (!command) return <Modal title={name} close={close}><p>rsegen has no command {name}.</p></Modal>;
  const job = jobs.value.find((each) => each.id === number);
  const isStarting = useRef(false); // a second press would be a second run
  const run = async (replace = false) => {
    if (isStarting.current) return;
    fail(null);
    const unread = unreadIn(form.current!) ?? (takesRecipe ? unreadIn(document) : null);
    if (unread) return fail(unread);
    const missing = command.fields.find((field) => field.required && isEmpty(values[field.name]));
    if (missing) return fail({ where: missing.name, text: missing.missing ?? "" });
    remembered.set(name, { values, output });
    isStarting.current = true;
    try {
      const started = await ask("run", { ...asked(), ...(replace && { replace }) });
      list(started);
      follow(started.id);
    } catch (error) {
      if (!(error instanceof Failed)) throw error;
      fail(error.failure);
    } finally {
      isStarting.current = false;
    }
  };
  const problems = (field: string) => (failure?.where === field ? failure.text : "");
  const form = useRef<HTMLFormElement>(null);
  useEffect(() => form.current?.querySelector(".field .problem")?.scrollIntoView({ block: "nearest" }), [failure]);
  const elsewhere = failure && !command.fields.some((field) => field.name === failure.where) && failure.where !== "output";
  return (
    <Modal title={command.title} close={close} wide={Boolean(job)}>
      {job ? <JobReport key={job.id} job={job} again={() => follow(null)} /> : (
        <form ref={form} noValidate onSubmit={(event) => { event.preventDefault(); void run(failure?.kind === "exists"); }}>
          <p class="lead">{command.help}{target && <> — on <code>{target}</code></>} · <a href={manual(name)} target="_blank">Manual</a></p>
          <Form fields={fieldsOf(command, target)} values={values} problems={problems} explained
            onChange={(field, value) => change((now) => ({ ...now, values: { ...now.values, [field]: value } }))} />
          {command.output !== "none" && <Labelled id={`${id}-output`} label={`${command.output === "folder" ? "Output folder" : "Output file"}${command.output_required ? "" : " (optional)"}`} help={`in ${hello.value!.folder}`} note={command.output_help} problem={problems("output")} wide>
            <input id={`${id}-output`} type="text" value={output} onInput={(event) => { const text = event.currentTarget.value; change((now) => ({ ...now, output: text })); }} />
          </Labelled>}
          <div class="shell">{line.text ? <code>{line.text}</code> : <small>{line.why}</small>}<Button icon="copy" class="quiet" title="Copy the command line" disabled={!line.text} onClick={() => void copy(line.text)} /></div>
          {state.value?.problem && takesRecipe && <p class="problem" role="alert">Correct the recipe first: {told(state.value.problem)}</p>}
          <footer class="actions">
            {elsewhere && <p class="problem" role="alert">{told(failure)}</p>}
            {upload && name === "scan" && <button type="button" onClick={() => (dialog.value = { name: "run", command: "compare", upload })}>Compare it with this map …</button>}
            <button type="button" onClick={close}>Cancel</button>
            <button type="submit" class="primary" disabled={Boolean(state.value?.problem) && takesRecipe}>{failure?.kind === "exists" ? "Replace the existing files" : "Run"}</button></footer>
        </form>
      )}
    </Modal>
  );
}

export function JobReport({ job, again }: { job: Job; again?: () => void }) {
  const drives = job.files.filter((file) => file.kind === "drive");
  const depth = (file?: Job["files"][number]) => file?.path.split("/").length;
  const isOnTop = (file: Job["files"][number]) => depth(file) === depth(job.files[0]); // the first is one of the highest
  return (
    <div class="job">
      <p class={`state ${job.state}`} role="status"><b>{job.state}</b> {job.state === "running" && <>{job.step} {job.total ? `${job.done ?? 0} of ${job.total}` : ""}</>}</p>
      {job.state === "running" && <Progress job={job} />}
      <div class="shell"><code>{job.line}</code><Button icon="copy" class="quiet" title="Copy the command line" onClick={() => void copy(job.line)} /></div>
      {job.command === "rate" && job.output && <RatingCurves job={job} />}
      <Report text={job.lines.join("\n")} isBad={job.state === "failed"} />
      <div class="pictures">{job.files.filter((file) => file.kind === "picture" && !isOfMap(file, job)).slice(0, 8).map((file) => <FilePicture key={file.path} {...file} wide={isOnTop(file) && !job.files.every(isOnTop)} />)}</div>
      {job.files.filter((file) => file.kind === "table" && isOnTop(file)).slice(0, 4).map((file) => <FileTable key={file.path} {...file} />)}
      <MadeMaps job={job} />
      <ul class="files">{job.files.filter((file) => file.kind !== "picture" && file.kind !== "recipe").map((file) => (
        <li key={file.path}><Icon name={file.kind === "drive" ? "play" : "file"} /><span>{file.name}</span>
          {file.kind === "drive" && <><button type="button" class="primary" onClick={() => { dialog.value = null; void play(file.path, false, robotOf(job)); }}>Play</button>
            {playbacks.value.length > 0 && <button type="button" onClick={() => { dialog.value = null; void play(file.path, true, robotOf(job)); }}>Play next to the other</button>}</>}
          {file.kind === "dataset" && <button type="button" onClick={() => void leaveFor(`${file.path}#0`)}>Open</button>}
          {file.kind === "pdf" && <button type="button" onClick={() => void show(file.path)}>Show</button>}
          {file.kind !== "drive" && file.kind !== "dataset" && <button type="button" class="quiet" onClick={() => void download(file)}>Download</button>}
        </li>))}</ul>
      <footer class="actions">
        {job.state === "running" ? <button type="button" onClick={() => void attempt(() => call("cancel", { job: job.id }))}>Cancel the run</button> : again && <button type="button" onClick={again}>Change and run again</button>}
        {job.files.length > 0 && <ShowFolder path={commonFolder(job.files)} />}
        {job.opens && <button type="button" class="primary" onClick={() => void leaveFor(job.opens!)}>Open the recipe</button>}
        {drives.length > 0 && <button type="button" class="primary" onClick={() => { dialog.value = null; void play(drives[0]!.path, false, robotOf(job)); }}>Play</button>}
        <button type="button" onClick={() => (dialog.value = null)}>Close</button>
      </footer>
    </div>
  );
}

/* The robot that was chosen last for the command of a run: drives know one of a file by the name of its model alone. */
const robotOf = (job: Job) => shown(remembered.get(job.command)?.values.robot);

type Made = Job["files"][number];
const folderOf = (file: Made) => file.path.replace(/\/?[^/]*$/, "");
const isOfMap = (picture: Made, job: Job) => job.files.some((file) => file.kind === "recipe" && folderOf(file) === folderOf(picture));

/* The deepest folder that has all files. */
const commonFolder = (files: Made[]): string =>
  files.map((file) => (file.kind === "drive" || file.kind === "dataset" ? file.path : folderOf(file)).split("/"))
    .reduce((one, other) => one.slice(0, one.findIndex((part, at) => part !== other[at]) >>> 0)).join("/") || ".";

const MOST_MAPS = 12; // that are shown with pictures

/* The maps that a command wrote: their names, pictures, and what people do with them next. */
function MadeMaps({ job }: { job: Job }) {
  const maps = job.state === "done" ? job.files.filter((file) => file.kind === "recipe") : [];
  const previewOf = (map: Made) => job.files.find((file) => file.kind === "picture" && /preview/.test(file.name) && folderOf(file) === folderOf(map));
  const bare = maps.slice(0, MOST_MAPS).filter((map) => !previewOf(map));
  const [drawn, draw] = useState<Map<string, SceneData>>(new Map());
  const wanted = bare.map((map) => map.path).join("\n");
  useEffect(() => {
    if (!wanted) return;
    const paths = wanted.split("\n");
    void attempt(() => call("made_maps", { paths }), false).then((found) => found && draw(new Map(found.map((each, at) => [paths[at]!, each.scene]))));
  }, [wanted]);
  if (!maps.length) return null;
  return (
    <>
      <h3>{maps.length === 1 ? "The map" : `${maps.length} maps`}</h3>
      <ul class="gallery">{maps.slice(0, MOST_MAPS).map((map) => (
        <li key={map.path} class="made">
          {previewOf(map) ? <FilePicture {...previewOf(map)!} wide={false} /> : drawn.has(map.path) && <Picture map={drawn.get(map.path)!} label={map.name} />}
          <b class="name">{map.name}</b>
          <button type="button" onClick={() => void openWorld(folderOf(map))}>Open in Gazebo</button>
          <button type="button" onClick={() => (dialog.value = { name: "run", command: "drive", target: folderOf(map) })}>Drive a robot here …</button>
          <button type="button" onClick={() => void leaveFor(map.path)}>Edit</button>
        </li>))}</ul>
      {maps.length > MOST_MAPS && <p class="note">and {maps.length - MOST_MAPS} more</p>}
    </>
  );
}

/* Open a map that was written in the simulator of this machine. */
async function openWorld(target: string): Promise<void> {
  const started = await attempt(() => ask("run", { command: "open", values: {}, target }));
  if (!started) return;
  list(started);
  dialog.value = { name: "jobs" };
}

/* Show files in the file manager of the server's machine; where there is none, their path, to copy. */
function ShowFolder({ path }: { path: string }) {
  const [place, set] = useState("");
  const look = async () => {
    const found = await attempt(() => call("show_folder", { path }));
    set(found && !found.is_open ? found.path : "");
  };
  if (place) return <span class="shell"><code>{place}</code><Button icon="copy" class="quiet" title="Copy the path of the folder" onClick={() => void copy(place)} /></span>;
  return <button type="button" onClick={() => void look()}>Show in folder</button>;
}

async function download(file: { path: string; name: string }): Promise<void> {
  const bytes = await attempt(() => fileOf(file.path));
  if (bytes) offer(bytes, file.name);
}

/* Let the browser save bytes as a file. */
export function offer(bytes: Blob, name: string): void {
  const link = Object.assign(document.createElement("a"), { href: URL.createObjectURL(bytes), download: name });
  link.click();
  URL.revokeObjectURL(link.href);
}

/* Show a PDF in a window of its own. */
async function show(path: string): Promise<void> {
  const bytes = await attempt(() => fileOf(path));
  if (bytes) window.open(URL.createObjectURL(new Blob([bytes], { type: "application/pdf" })));
}

const MOST_ROWS = 60; // longer ones are for programs

/* The cells of a line of CSV, of which each follows a comma, so that an empty first one is a cell too. */
const cellsOf = (row: string): string[] =>
  [...`,${row}`.matchAll(/,(?:"((?:[^"]|"")*)"|([^,]*))/g)].map(([, quoted, plain]) => quoted?.replaceAll('""', '"') ?? plain ?? "");

/* What a command says: text, with tables and headings of Markdown as such. */
function Report({ text, isBad }: { text: string; isBad: boolean }) {
  return <>{text.split(/((?:^\|.*\|$\n?)+|^#+ .*$)/m).map((part, at) => {
    if (!part.trim()) return null;
    if (part.startsWith("#")) return <h3 key={at}>{part.replace(/^#+ /, "")}</h3>;
    if (!part.startsWith("|")) return <pre key={at} tabindex={0} role="group" aria-label="Report" class={isBad ? "bad" : ""}>{part.trim()}</pre>;
    const rows = part.trim().split("\n").map((row) => row.slice(1, -1).split("|").map((cell) => cell.trim()));
    return <Rows key={at} rows={rows.filter((row) => !row.every((cell) => /^:?-+:?$/.test(cell)))} />;
  })}</>;
}

/* A table, the first row of which names its columns. */
function Rows({ rows: [head, ...body], name }: { rows: string[][]; name?: string }) {
  return (
    <figure class="table" tabindex={0}>
      <table class="csv"><thead><tr>{head!.map((each, at) => <th scope="col" key={at}>{each.replaceAll("_", " ")}</th>)}</tr></thead>
        <tbody>{body.map((row, at) => <tr key={at}>{row.map((each, k) => <td key={k}>{each}</td>)}</tr>)}</tbody></table>
      {name && <figcaption>{name}</figcaption>}
    </figure>
  );
}

/* A table that a run wrote, if it is one to be read: short, with a line of names. */
function FileTable({ path, name }: { path: string; name: string }) {
  const [rows, set] = useState<string[][]>([]);
  useEffect(() => void attempt(async () => (await fileOf(path)).text(), false).then((text) => text && set(text.trim().split(/\r?\n/).map(cellsOf))), [path]);
  const [head, ...body] = rows;
  if (!head || body.length > MOST_ROWS || head[0]?.startsWith("#")) return null;
  return <Rows rows={rows} name={name} />;
}

function FilePicture({ path, name, wide }: { path: string; name: string; wide: boolean }) {
  const source = useAddress(() => attempt(() => fileOf(path), false), [path]);
  return source ? <figure class={wide ? "wide" : ""}><img src={source} alt={name} /><figcaption>{name}</figcaption></figure> : null;
}

/* All runs since the page was opened. */
export function Jobs() {
  return (
    <Modal title="Runs" close={() => (dialog.value = null)} wide>
      {jobs.value.length ? jobs.value.map((job) => <details key={job.id} open={job === jobs.value[0]}><summary>{titleOf(job.command)} <small>{job.state}</small></summary><JobReport job={job} /></details>) : <p class="empty">You have not run a command yet.</p>}
    </Modal>
  );
}
