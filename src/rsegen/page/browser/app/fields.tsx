/* Forms, made of the parameters that the program declares: one control for each type of value. */

import { useId, useState } from "preact/hooks";
import { Labelled, ListInput, NumberInput, Segmented, Select, Slider, Switch, Unreadable, useTyped } from "./controls";
import { shown } from "./exact";
import type { Field, Json, Schema } from "./protocol";
import { hello } from "./state";

type Change = (value: Json | undefined, gesture: string) => void;

export function FieldControl({ field, value, problem, onChange, explained }: {
  field: Field; value: Json | undefined; problem?: string; onChange: Change; explained?: boolean;
}) {
  const id = useId();
  const [why, setWhy] = useState("");
  const { schema, title, help, unit } = field;
  const given = value ?? field.default ?? undefined;
  const wide = Boolean(schema.anyOf) || isWordy(schema) || Boolean(field.slider);
  return (
    <Labelled id={id} label={title} help={help} unit={unit} problem={why || problem} wide={wide} note={explained && help}
      long={Number(schema.maximum ?? 0) > Number.MAX_SAFE_INTEGER}>
      <Control id={id} schema={schema} slider={field.slider} name={title} value={given} empty={field.default === null} problem={problem}
        onChange={onChange} onWhy={setWhy} />
    </Labelled>
  );
}

interface ControlProps {
  id: string; schema: Schema; slider?: [number, number] | null; name: string; value: Json | undefined; empty: boolean; problem?: string;
  onChange: Change; onWhy: (why: string) => void;
}

const isNumber = (schema: Schema) => schema.type === "integer" || schema.type === "number";
const isWordy = (schema: Schema) => (schema.enum?.join("").length ?? 0) > 12 || schema.type === "string" || schema.type === "array";
const words = (name: string) => (/_\d{4}$/.test(name) ? name : name.replaceAll("_", " ")); // a map keeps its name

function Control(props: ControlProps) {
  const { id, schema, name, value, empty, problem, onChange, onWhy } = props;
  if (schema.enum) {
    const choices = schema.enum.map((each) => [each, words(each)] as const);
    const choose = (choice: string) => onChange(choice || undefined, "");
    if (!empty && choices.length < 5 && schema.enum.join("").length < 30)
      return <Segmented id={id} name={name} value={String(value ?? "")} choices={choices} onChange={choose} />;
    const all = empty || value === undefined ? [["", "not set"] as const, ...choices] : choices;
    return <Select id={id} value={String(value ?? "")} choices={all} onChange={choose} />;
  }
  if (schema.type === "boolean") return <Switch id={id} value={value === true} onChange={(next) => onChange(next, "")} />;
  if (isNumber(schema)) {
    const whole = schema.type === "integer";
    const { minimum, maximum } = schema;
    const number = { id, value, whole, empty, minimum, maximum, onChange, onWhy, problem, name };
    if (!props.slider) return <NumberInput {...number} name={undefined} placeholder={empty ? "not set" : ""} />;
    const [low, high] = props.slider;
    return <Slider {...number} low={low} high={high} step={whole || high - low > 50 ? 1 : high - low > 5 ? 0.1 : 0.01} />;
  }
  if (schema.anyOf && schema.anyOf.every((each) => each.enum || each.type === "string")) return <WordOrText {...props} />;
  if (schema.anyOf) return <AnyOf {...props} />;
  if (schema.type === "array") return <ArrayControl {...props} />;
  return <TextControl {...props} />;
}

function TextControl({ id, schema, value, empty, onChange, onWhy }: ControlProps) {
  const pattern = schema.pattern ? new RegExp(schema.pattern) : null;
  const read = (text: string) => {
    if (!text && empty) return undefined;
    return pattern && !pattern.test(text) ? new Unreadable(`'${text}' has characters that are not allowed here`) : text;
  };
  const { why, props } = useTyped(value, read, onChange);
  if (schema.pattern?.startsWith("^#"))
    return <>
      <input type="color" aria-label="choose a colour" value={typeof value === "string" ? value : "#808080"}
        onInput={(event) => onChange(event.currentTarget.value, id)} />
      <input id={id} type="text" {...props} aria-invalid={Boolean(why)} placeholder={empty ? "default" : ""} />
    </>;
  return <input id={id} type="text" autocomplete="off" {...props} aria-invalid={Boolean(why)} onBlur={() => (onWhy(why), props.onBlur())} />;
}

const OTHER = " "; // no word is a blank

/* One of some known words, or another text, such as the path of a file; robots with what they are like. */
function WordOrText({ id, schema, name, value, empty, onChange }: ControlProps) {
  const known = schema.anyOf!.flatMap((each) => each.enum ?? []);
  const robots = hello.value?.robots ?? [];
  const areRobots = known.length > 0 && known.every((word) => robots.some((robot) => robot.name === word));
  const choices = areRobots ? robots.map((robot) => [robot.name, robot.title] as const) : known.map((word) => [word, words(word)] as const);
  const isListed = choices.some(([word]) => word === value);
  const [isOther, takeOther] = useState(false);
  const { props } = useTyped(isListed ? undefined : value, (text) => text || undefined, onChange);
  const shows = isOther || (value !== undefined && !isListed);
  const choose = (choice: string) => {
    takeOther(choice === OTHER);
    onChange(choice.trim() || undefined, "");
  };
  return (
    <div class="choice">
      <Select id={id} value={shows ? OTHER : String(value ?? "")} onChange={choose}
        choices={[...(empty || value === undefined ? [["", "not set"] as const] : []), ...choices, [OTHER, areRobots ? "from a file …" : "other …"] as const]} />
      {shows && <input type="text" autocomplete="off" aria-label={areRobots ? "File of a robot" : `${name}: other value`} placeholder={areRobots ? "robot.sdf, robot.urdf, or robot.xacro NAME:=VALUE" : ""} {...props} />}
    </div>
  );
}

/* Pairs and triples as so many numbers, other lists in one text. */
function ArrayControl(props: ControlProps) {
  const { id, schema, name, value, onChange, onWhy } = props;
  const items = schema.prefixItems ?? (schema.minItems === schema.maxItems && schema.items ? Array<Schema>(schema.minItems ?? 0).fill(schema.items) : []);
  const whole = (schema.items ?? items[0])?.type === "integer";
  if (items.length && items.every(isNumber)) {
    const numbers = Array.isArray(value) ? value : items.map(() => value ?? null);
    return (
      <div class="row" role="group" aria-label={name}>
        {items.map((item, at) => (
          <NumberInput key={at} id={`${id}-${at}`} name={`${name}, ${at + 1}`} whole={item.type === "integer"} value={numbers[at]}
            onWhy={onWhy} step={item.maximum === 1 ? 0.05 : 1}
            onChange={(next, gesture) => onChange(numbers.map((each, k) => (k === at ? (next ?? null) : each)), gesture)} />
        ))}
      </div>
    );
  }
  if (schema.items && isNumber(schema.items))
    return <ListInput id={id} name={name} whole={whole} value={value} onChange={onChange} onWhy={onWhy} placeholder="numbers, separated by spaces" />;
  if (schema.items?.anyOf?.some((each) => each.enum)) return <Words {...props} />;
  return <LinesControl {...props} />;
}

/* Known words to switch on and off, and other texts: formats, some with options. */
function Words(props: ControlProps) {
  const { id, name, schema, value, onChange } = props;
  const texts = Array.isArray(value) ? value.map(shown) : [];
  const isOf = (word: string) => (text: string) => text.split(" ")[0] === word;
  const turn = (word: string) => onChange(texts.some(isOf(word)) ? texts.filter((text) => !isOf(word)(text)) : [...texts, word], "");
  return (
    <div class="words" role="group" aria-label={name}>
      {schema.items!.anyOf!.flatMap((each) => each.enum ?? []).map((word, at) => (
        <button type="button" key={word} title={hello.value?.formats.find((format) => format.name === word)?.description} id={at === 0 ? id : undefined} aria-pressed={texts.some(isOf(word))} onClick={() => turn(word)}>{word}</button>))}
      {texts.length > 0 && <LinesControl {...props} id={`${id}-texts`} name={`${name}, one per line, with options after the name`} />}
    </div>
  );
}

/* Texts, or rows of numbers, one on a line. */
function LinesControl({ id, name, value, onChange }: ControlProps) {
  const text = Array.isArray(value) ? value.map(shown).join("\n") : shown(value);
  return <textarea id={id} rows={Math.min(12, text.split("\n").length + 1)} spellcheck={false} value={text} placeholder="one per line" aria-label={name}
    onChange={(event) => onChange(event.currentTarget.value.split("\n").map((line) => line.trim()).filter(Boolean), "")} />;
}

/* What forms of a value are called that have no title, as those of a plug-in. */
const FORMS: { [type: string]: string } = { array: "a list", string: "a text", boolean: "yes or no", integer: "a number", number: "a number" };

function fits(schema: Schema, value: Json | undefined): boolean {
  const isText = schema.type === "string" || Boolean(schema.enum ?? schema.anyOf);
  if (!Array.isArray(value)) return schema.type !== "array" && (typeof value === "string") === isText;
  const count = schema.prefixItems?.length ?? schema.minItems;
  return schema.type === "array" && (schema.prefixItems || schema.minItems === schema.maxItems ? count === value.length : true);
}

/* One of several forms of a value, such as one number or two. */
function AnyOf(props: ControlProps) {
  const choices = props.schema.anyOf!;
  const [chosen, choose] = useState<number | null>(null);
  const found = choices.findIndex((schema) => fits(schema, props.value));
  const at = props.value !== undefined && found >= 0 && chosen === null ? found : (chosen ?? Math.max(found, 0));
  const names = choices.map((schema, number) => [String(number), schema.title ?? FORMS[String(schema.type)] ?? "a word"] as const);
  const use = (number: string) => {
    const [next, first] = [choices[Number(number)]!, Array.isArray(props.value) ? props.value[0] : props.value];
    const count = next.prefixItems?.length ?? (next.minItems === next.maxItems ? next.minItems : 1) ?? 1;
    choose(Number(number));
    if (first === undefined || typeof first === "string" || next.type === "string" || next.anyOf) return;
    // A third number of a range is a number of steps.
    const filled = Array.from({ length: count }, (_, k) => (k < 2 ? first : (next.prefixItems?.[k]?.minimum ?? first)));
    props.onChange(next.type === "array" ? filled : first, "");
  };
  return (
    <div class="any">
      <Segmented name={`${props.name}: form`} value={String(at)} choices={names} onChange={use} />
      <Control {...props} slider={null} schema={choices[at]!} value={fits(choices[at]!, props.value) ? props.value : undefined} />
    </div>
  );
}

/* A form: basic parameters, and the others under More. */
export function Form({ fields, values, problems, onChange, more = "More", explained }: {
  fields: Field[]; values: { [name: string]: Json | undefined }; problems: (name: string) => string; more?: string; explained?: boolean;
  onChange: (name: string, value: Json | undefined, gesture: string) => void;
}) {
  const control = (field: Field) => (
    <FieldControl key={field.name} field={field} value={values[field.name]} problem={problems(field.name)} explained={explained}
      onChange={(value, gesture) => onChange(field.name, value, gesture)} />
  );
  const [basic, others] = [fields.filter((field) => field.basic), fields.filter((field) => !field.basic)];
  const wrong = others.some((field) => problems(field.name));
  return (
    <div class="form">
      {basic.map(control)}
      {others.length > 0 && (basic.length === 0 ? others.map(control) : (
        <details open={wrong || undefined}><summary>{more}</summary><div class="form">{others.map(control)}</div></details>
      ))}
    </div>
  );
}
