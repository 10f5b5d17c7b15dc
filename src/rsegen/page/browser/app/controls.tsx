/* The controls of the page: native ones, with a label, a unit, and the error of what was typed. */

import { computed, signal } from "@preact/signals";
import type { ComponentChildren, JSX, TargetedFocusEvent, TargetedInputEvent, TargetedKeyboardEvent, TargetedToggleEvent } from "preact";
import { useEffect, useId, useRef, useState } from "preact/hooks";
import { equal, shown, typed, typedList } from "./exact";
import type { Job, Json } from "./protocol";
import { edit, newGesture } from "./state";

/* Lines on a grid of 16 units. */
const ICONS = {
  select: "M4 2.5v10l2.6-2.3 1.8 3.6 1.7-.9-1.8-3.4 3.4-.5z",
  paint: "M13.5 2.5 7 9M6.6 8.6c-2.600 0-2.300 3.400-4.600 3.700 2.400 2.500 6.400.7 5.900-2.500z",
  draw: "M3 13 13 3M3 13h.01M13 3h.01M2 11.500v2.500h2.500M14 4.500V2h-2.500",
  robot: "M3.500 6h9v5h-9zM8 6V3.500M5 13.500h1M10 13.500h1M6 8.500h.01M10 8.500h.01M8 3.500h.01",
  way: "M3.500 13a1.200 1.200 0 1 0 0-.01M12.500 4a1.200 1.200 0 1 0 0-.01M4.500 12.500c5 0 1-8 7-8.500",
  undo: "M6 3 3 6l3 3M3 6h6.500a3.500 3.500 0 0 1 0 7H7",
  redo: "m10 3 3 3-3 3M13 6H6.500a3.500 3.500 0 0 0 0 7H9",
  add: "M8 3v10M3 8h10",
  remove: "M3 8h10",
  copy: "M5.500 5.500h8v8h-8zM10.500 5.500v-3h-8v8h3",
  dice: "M2.500 4.500a2 2 0 0 1 2-2h7a2 2 0 0 1 2 2v7a2 2 0 0 1-2 2h-7a2 2 0 0 1-2-2zM5.700 5.400a.3.3 0 1 0 .01 0M8 7.700a.3.3 0 1 0 .01 0M10.300 10a.3.3 0 1 0 .01 0",
  play: "M5 3l8 5-8 5z",
  pause: "M5 3v10M11 3v10",
  more: "M3.500 8h.01M8 8h.01M12.500 8h.01",
  down: "m4 6 4 4 4-4",
  close: "m4 4 8 8M12 4l-8 8",
  file: "M4 2h5l3 3v9H4zM9 2v3h3",
  folder: "M2 4h4l1.500 1.500H14V13H2z",
  left: "m10 3-5 5 5 5",
  right: "m6 3 5 5-5 5",
  help: "M6 6a2 2 0 1 1 2.600 1.900c-.6.2-.6.700-.6 1.600M8 12.500h.01",
  grow: "M9.500 2.500h4v4M13.500 2.500l-5 5M6.500 13.500h-4v-4M2.500 13.500l5-5",
  shrink: "M13.500 2.500l-5 5M8.500 3.500v4h4M2.500 13.500l5-5M7.500 12.500v-4h-4",
  warn: "M8 2.500 14 13H2zM8 6.500v3M8 11.300h.01",
};
export type IconName = keyof typeof ICONS;

export const Icon = ({ name }: { name: IconName }) => (
  <svg class="icon" viewBox="0 0 16 16" aria-hidden="true"><path d={ICONS[name]} /></svg>
);

type ButtonProps = JSX.IntrinsicElements["button"] & {
  icon?: IconName; title: string; children?: ComponentChildren; pressed?: boolean;
};

/* A button; one without a text is named by its title. */
export function Button({ icon, children, pressed, class: name = "", ...rest }: ButtonProps) {
  const plain = children ? name : `${String(name)} square`;
  return (
    <button type="button" class={plain} aria-pressed={pressed} aria-label={children ? undefined : rest.title} {...rest}>
      {icon && <Icon name={icon} />}
      {children}
    </button>
  );
}

/* The address of bytes that are being made, empty until then, such as those of a picture. */
export function useAddress(made: () => Promise<Blob | null>, of: unknown[]): string {
  const [address, show] = useState("");
  useEffect(() => {
    let own = "";
    void made().then((bytes) => bytes && show((own = URL.createObjectURL(bytes))), () => null);
    return () => URL.revokeObjectURL(own);
  }, of);
  return address;
}

/* A button that opens a list below it; a choice in it closes it. */
export function Menu({ label, icon, title, children, class: name = "", wide = false, onClose }: {
  label?: ComponentChildren; icon?: IconName; title: string; children: ComponentChildren; class?: string; wide?: boolean; onClose?: () => void;
}) {
  const id = useId();
  const list = useRef<HTMLDivElement>(null);
  const place = (event: TargetedToggleEvent<HTMLDivElement>) => {
    if (event.newState !== "open") return onClose?.();
    const menu = list.current!;
    const at = (menu.previousElementSibling as HTMLElement).getBoundingClientRect();
    menu.style.left = `${Math.max(8, Math.min(at.left, innerWidth - menu.offsetWidth - 8))}px`;
    const below = at.bottom + 4 + menu.offsetHeight < innerHeight || at.top < innerHeight / 2;
    menu.style.top = below ? `${at.bottom + 4}px` : `${Math.max(8, at.top - menu.offsetHeight - 4)}px`;
    menu.style.maxHeight = `${innerHeight - (below ? at.bottom + 12 : 16)}px`;
    menu.querySelector<HTMLElement>("button:not(:disabled)")?.focus();
  };
  const walk = (event: TargetedKeyboardEvent<HTMLDivElement>) => {
    const items = [...list.current!.querySelectorAll<HTMLElement>("button:not(:disabled), a.button")];
    const at = items.indexOf(document.activeElement as HTMLElement);
    const to = { ArrowDown: at + 1, ArrowUp: at - 1, Home: 0, End: -1 }[event.key];
    if (to === undefined) return;
    event.preventDefault();
    items.at(to % items.length)?.focus();
  };
  // Tab out of the list closes it; otherwise it would lie over what has the focus.
  const leave = ({ relatedTarget: to }: TargetedFocusEvent<HTMLDivElement>) => {
    if (to instanceof Node && !list.current!.contains(to)) list.current!.hidePopover();
  };
  return (
    <>
      <button type="button" class={`${name} ${label ? "" : "square"}`} title={title} aria-label={label ? undefined : title}
        popovertarget={id}>
        {icon && <Icon name={icon} />}
        {label}
        {label && <Icon name="down" />}
      </button>
      <div id={id} ref={list} popover="auto" class={wide ? "menu wide" : "menu"} onToggle={place} onKeyDown={walk} onFocusOut={leave}
        onClick={(event) => (event.target as Element).closest("button, a") && list.current!.hidePopover()}>
        {wide ? <div>{children}</div> : children}
      </div>
    </>
  );
}

let opener: Element | null = null; // what had the focus before a dialog, and gets it again after it

/* A dialog over the page; Escape, its cross and a press next to it close it. */
export function Modal({ title, close, children, wide = false }: {
  title: string; close: () => void; children: ComponentChildren; wide?: boolean;
}) {
  const box = useRef<HTMLDialogElement>(null);
  const id = useId();
  const pressed = useRef<EventTarget | null>(null); // a text that is selected with the mouse may end next to the dialog
  useEffect(() => {
    if (document.activeElement !== document.body) opener = document.activeElement;
    box.current!.showModal();
    const first = box.current!.querySelector<HTMLElement>(".body :is(input, select, textarea, button):not(:disabled)");
    first?.focus();
    if (!first) box.current!.querySelector<HTMLElement>(".body")!.tabIndex = 0; // to scroll it by keys
    return () => setTimeout(() => {
      if (document.activeElement === document.body && opener instanceof HTMLElement) opener.focus();
    });
  }, []);
  return (
    <dialog ref={box} class={wide ? "wide" : ""} aria-labelledby={id} onClose={close}
      onPointerDown={(event) => (pressed.current = event.target)}
      onClick={(event) => event.target === box.current && pressed.current === box.current && close()}>
      <header><h2 id={id}>{title}</h2><Button icon="close" title="Close" class="quiet" onClick={close} /></header>
      <div class="body">{children}</div>
    </dialog>
  );
}

/* What a control has around it. */
export interface Labelled { label: string; help?: string; unit?: string; problem?: string }

export function Labelled({ label, help, unit, problem, id, wide, long, note, children }: Labelled & {
  id: string; wide?: boolean; long?: boolean; note?: ComponentChildren; children: ComponentChildren;
}) {
  return (
    <div class={`field ${wide ? "tall" : ""} ${long ? "long" : ""}`} data-field={label}>
      <label for={id} title={help}>{label}{unit && <small>, {unit}</small>}</label>
      <div class="control">{children}</div>
      {note && <p class="note">{note}</p>}
      {problem && <p class="problem" id={`${id}-problem`} role="alert">{problem}</p>}
    </div>
  );
}

/* The text of a value while it is typed: the recipe gets what can be read, and the field keeps what was typed until then.

   read gives the value of a text, or Unreadable. */
export class Unreadable { constructor(readonly why: string) {} }

/* What forgets a text that cannot be read, of each field that has one now. */
const unreadable = signal<readonly (() => void)[]>([]);
export const hasUnreadable = computed(() => unreadable.value.length > 0);

/* Undo: of texts that cannot be read, which changed nothing and were typed last, or else of the last change. */
export function undo(): void {
  if (hasUnreadable.value) unreadable.value.forEach((forget) => forget());
  else void edit({ do: "undo" });
}

export function useTyped(value: Json | undefined, read: (text: string) => Json | undefined | Unreadable,
  change: (value: Json | undefined, gesture: string) => void) {
  const [text, setText] = useState<string | null>(null);
  const gesture = useRef("");
  const focused = useRef(false);
  const before = useRef<Json | undefined>(undefined);
  const now = text === null ? undefined : read(text);
  const why = now instanceof Unreadable ? now.why : "";
  const input = useRef<HTMLInputElement>(null);
  useEffect(() => input.current?.setCustomValidity(why), [why]); // so that nothing is run with the earlier value
  useEffect(() => {
    if (!why) return;
    const forget = () => setText(null);
    unreadable.value = [...unreadable.peek(), forget];
    return () => { unreadable.value = unreadable.peek().filter((each) => each !== forget); };
  }, [Boolean(why)]);
  useEffect(() => {
    // The value of the document replaces what was typed, also if it was undone meanwhile.
    if (text === null || now instanceof Unreadable) return;
    if (!focused.current || !equal(now ?? null, value ?? null)) setText(null);
  }, [written(value)]);
  return {
    why,
    props: {
      ref: input,
      value: text ?? shown(value),
      onFocus: () => { focused.current = true; gesture.current = newGesture(); before.current = value; },
      onInput: (event: TargetedInputEvent<HTMLInputElement>) => {
        setText(event.currentTarget.value);
        const next = read(event.currentTarget.value);
        // What cannot be read leaves no trace of its readable beginning, such as 0 of 0x10.
        const wanted = next instanceof Unreadable ? before.current : next;
        if (!equal(wanted ?? null, value ?? null)) change(wanted, gesture.current);
      },
      onBlur: () => { focused.current = false; if (!(now instanceof Unreadable)) setText(null); },
    },
    forget: () => setText(null),
  };
}
const written = (value: Json | undefined) => shown(value) + typeof value;

type NumberProps = {
  id: string; value: Json | undefined; whole: boolean; empty?: boolean; minimum?: number; maximum?: number; step?: number;
  name?: string; onChange: (value: Json | undefined, gesture: string) => void; onWhy?: (why: string) => void;
  problem?: string; placeholder?: string; disabled?: boolean;
};

/* A number in any locale; arrow keys step it. empty: it may be left out. */
export function NumberInput(props: NumberProps) {
  const { id, value, whole, empty, onChange, onWhy, minimum = -Infinity, maximum = Infinity, step = 1 } = props;
  const read = (text: string) => {
    if (empty && !text.trim()) return undefined;
    const number = typed(text, whole);
    return typeof number === "string" ? new Unreadable(number) : number;
  };
  const { why, props: input, forget } = useTyped(value, read, onChange);
  useEffect(() => onWhy?.(why), [why]);
  const nudge = (event: TargetedKeyboardEvent<HTMLInputElement>) => {
    if (event.key === "Escape") forget();
    const direction = event.key === "ArrowUp" ? 1 : event.key === "ArrowDown" ? -1 : 0;
    if (!direction || typeof value !== "number") return;
    event.preventDefault();
    forget();
    const by = direction * step * (event.shiftKey ? 10 : 1);
    onChange(Math.min(maximum, Math.max(minimum, Number((value + by).toPrecision(12)))), newGesture());
  };
  return (
    <input id={id} type="text" inputMode={whole ? "numeric" : "decimal"} autocomplete="off" class="number" {...input}
      onKeyDown={nudge} aria-label={props.name} aria-invalid={Boolean(why || props.problem)} disabled={props.disabled}
      aria-describedby={why || props.problem ? `${id}-problem` : undefined} placeholder={props.placeholder} />
  );
}

/* Numbers in a row, such as 0 3 5. */
export function ListInput({ id, value, whole, onChange, onWhy, placeholder, name }: NumberProps) {
  const read = (text: string) => {
    if (!text.trim()) return undefined;
    const numbers = typedList(text, whole);
    return typeof numbers === "string" ? new Unreadable(numbers) : numbers;
  };
  const { why, props } = useTyped(value, read, onChange);
  useEffect(() => onWhy?.(why), [why]);
  return <input id={id} type="text" autocomplete="off" {...props} aria-invalid={Boolean(why)} aria-label={name}
    placeholder={placeholder} />;
}

/* A slider with its number; the slider ends where most people need it to, the number where the recipe does. */
export function Slider(props: NumberProps & { low: number; high: number }) {
  const { id, value, low, high, step = 1, onChange } = props;
  const gesture = useRef("");
  const at = typeof value === "number" ? Math.min(high, Math.max(low, value)) : low;
  return (
    <>
      <input type="range" aria-label={`${props.name ?? ""} slider`} min={low} max={high} step={step} value={at}
        disabled={props.disabled} style={{ "--part": (at - low) / (high - low || 1) }}
        onPointerDown={() => (gesture.current = newGesture())} onFocus={() => (gesture.current = newGesture())}
        onInput={(event) => onChange(Number(event.currentTarget.value), gesture.current)} />
      <NumberInput {...props} id={id} />
    </>
  );
}

export function Switch({ id, value, onChange, name }: {
  id?: string; value: boolean; onChange: (value: boolean) => void; name?: string;
}) {
  return <input id={id} type="checkbox" role="switch" class="switch" aria-label={name} checked={value}
    onChange={(event) => onChange(event.currentTarget.checked)} />;
}

/* One of few words: a segmented control, of radio buttons. */
export function Segmented<T extends string>({ id, name, value, choices, onChange }: {
  id?: string; name: string; value: T; choices: readonly (readonly [T, ComponentChildren, string?])[]; onChange: (value: T) => void;
}) {
  const group = useId();
  return (
    <div class="segmented" role="radiogroup" aria-label={name}>
      {choices.map(([choice, text, title], at) => (
        <label key={choice} title={title}>
          <input id={at === 0 ? id : undefined} type="radio" name={group} checked={value === choice}
            onChange={() => onChange(choice)} />
          <span>{text}</span>
        </label>
      ))}
    </div>
  );
}

export function Select<T extends string>({ id, name, value, choices, onChange }: {
  id?: string; name?: string; value: T; choices: readonly (readonly [T, string, string?])[]; onChange: (value: T) => void;
}) {
  return (
    <select id={id} aria-label={name} value={value} onChange={(event) => onChange(event.currentTarget.value as T)}>
      {choices.map(([choice, text, title]) => <option key={choice} value={choice} title={title}>{text}</option>)}
    </select>
  );
}

/* How far a run is; without an end, that it goes on. */
export function Progress({ job }: { job: Job }) {
  return <progress max={job.total ?? 1} value={job.total ? (job.done ?? 0) : undefined} aria-label={`Progress of ${job.command}`} />;
}
