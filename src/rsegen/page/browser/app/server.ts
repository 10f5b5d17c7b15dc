/* The door to the server: calls, events, files. A frozen page has no server, and its data in the page. */

import { read, written } from "./exact";
import type { Calls, Event, Failure } from "./protocol";

const token = new URLSearchParams(location.search).get("token") ?? "";
const headers = { Authorization: `Bearer ${token}`, "Content-Type": "application/json" };

/* The address of the manual on this server: of a command, or of all. */
export const manual = (command = ""): string => `manual?token=${encodeURIComponent(token)}#${command}`;

/* What a call failed with: shown where `where` says. */
export class Failed extends Error {
  constructor(readonly failure: Failure) {
    super(failure.text);
  }
}

async function answer(response: Response): Promise<Response> {
  if (response.ok) return response;
  const said = await response.json().catch(() => null);
  throw new Failed(said?.error ?? { where: "", text: `the server answered with error ${response.status}` });
}

export const SILENT = "rsegen gui does not answer";

/* Call a function of the server by its name. */
export async function call<N extends keyof Calls>(name: N, args: Calls[N]["args"]): Promise<Calls[N]["result"]> {
  const response = await fetch(`api/${name}`, { method: "POST", headers, body: written(args) }).catch(() => {
    throw new Failed({ where: "", text: `${SILENT}: start it again in the same folder` });
  });
  return read<Calls[N]["result"]>(await (await answer(response)).text());
}

/* Send the bytes of a file; gives the path by which commands may read it. */
export async function upload(file: File): Promise<string> {
  const response = await fetch(`api/upload?name=${encodeURIComponent(file.name)}`, {
    method: "POST",
    headers: { Authorization: headers.Authorization },
    body: file,
  });
  return ((await (await answer(response)).json()) as { path: string }).path;
}

/* Return a file under the server's folder, to show or to download. */
export async function fileOf(path: string): Promise<Blob> {
  const response = await fetch("api/file", { method: "POST", headers, body: JSON.stringify({ path }) });
  return (await answer(response)).blob();
}

/* Hear the events of a document, until the signal ends it; after a break it is tried again.

   lost: told why there are no events, as the server says or SILENT says of it; empty once there are. */
export async function listen(
  doc: string, page: string, heard: (event: Event) => void, lost: (why: string) => void, ends: AbortSignal,
): Promise<void> {
  while (!ends.aborted) {
    let why = SILENT;
    try {
      const response = await fetch("api/events", { method: "POST", headers, body: written({ doc, page }), signal: ends });
      const lines = (await answer(response)).body!.pipeThrough(new TextDecoderStream()).getReader();
      lost("");
      let rest = "";
      for (let part = await lines.read(); !part.done; part = await lines.read()) {
        const whole = (rest + part.value).split("\n");
        rest = whole.pop()!;
        whole.filter(Boolean).forEach((line) => heard(read<Event>(line)));
      }
    } catch (error) {
      if (ends.aborted) return;
      if (error instanceof Failed) why = error.message;
    }
    lost(why);
    await new Promise((resume) => setTimeout(resume, 1500));
  }
}
