/* The page: fills in what the data says of a map, and joins the two views. All text is set as text, never as HTML. */

const DATA = JSON.parse(document.getElementById("data").textContent);
const part = (id) => document.getElementById(id);

function element(name, text, ...children) {
  const made = document.createElement(name);
  if (text) made.textContent = text;
  made.append(...children);
  return made;
}

function fillFacts(map) {
  part("name").textContent = map.name;
  part("description").textContent = map.description;
  part("facts").replaceChildren(
    ...map.facts.map(([name, value]) => element("div", "", element("dt", name), element("dd", value))),
  );
}

function fillLegend(map) {
  const most = Math.max(1, ...map.palette.map((entry) => entry.count));
  const rows = map.palette.map((entry) => {
    const swatch = element("i");
    swatch.style.background = entry.colour;
    const bar = element("span");
    bar.style.width = `${(100 * entry.count) / most}%`;
    const name = entry.level === null ? "frame" : `level ${entry.level}`;
    const cells = [
      element("td", "", swatch, name),
      element("td", `${entry.label} ${map.unit}`),
      element("td", entry.count.toLocaleString("en")),
      element("td", "", bar),
    ];
    cells[3].className = "bar";
    return element("tr", "", ...cells);
  });
  part("legend").tBodies[0].replaceChildren(...rows.reverse());
}

function fillMetrics(map) {
  const rows = map.metrics.map(([name, value, meaning]) =>
    element("tr", "", element("td", name, element("small", meaning)), element("td", value)),
  );
  part("metrics").tBodies[0].replaceChildren(...rows);
}

function fillRecipe(map) {
  part("recipe").hidden = !map.recipe;
  part("text").textContent = map.recipe;
  part("save").href = `data:text/plain;charset=utf-8,${encodeURIComponent(map.recipe)}`;
  part("save").download = map.file;
  part("command").replaceChildren("The same map again: ", element("code", `rsegen generate ${map.file} -o worlds`));
}

async function copyRecipe() {
  const text = part("text").textContent;
  try {
    await navigator.clipboard.writeText(text);
  } catch {
    getSelection().selectAllChildren(part("text"));
    document.execCommand("copy");
  }
  part("copy").textContent = "Copied";
  setTimeout(() => (part("copy").textContent = "Copy"), 1500);
}

function started(make) {
  try {
    return make();
  } catch (error) {
    console.warn(error);
    part("problem").textContent = "This browser shows no 3D graphics (WebGL 2).";
    part("problem").hidden = false;
    return null;
  }
}

const solid = started(() => new Solid(part("view"), [part("axis-x"), part("axis-y")]));
const plan = new Plan(part("plan"), part("mark"), part("flat-note"));
const views = [solid, plan].filter(Boolean);
let field = null;

function choose(number) {
  const map = DATA.maps[number];
  field = new Field(map);
  [fillFacts, fillLegend, fillMetrics, fillRecipe].forEach((fill) => fill(map));
  views.forEach((view) => view.show(field));
}

/* Say what is at the mouse or finger, and mark it in both views. */
function point(view, event) {
  const frame = event.currentTarget.getBoundingClientRect();
  const cell = view.cellAt(event.clientX - frame.left, event.clientY - frame.top);
  views.forEach((each) => each.highlight(cell));
  const tip = part("tip");
  tip.hidden = !cell;
  if (!cell) return;
  const { height, place, at } = field.described(...cell);
  tip.replaceChildren(element("b", height), ` ${place}`, element("small", at));
  const left = Math.min(event.clientX + 14, document.documentElement.clientWidth - tip.offsetWidth - 4);
  const above = event.clientY - tip.offsetHeight - 12;
  tip.style.transform = `translate(${Math.max(4, left)}px, ${above < 4 ? event.clientY + 18 : above}px)`;
}

function leave() {
  views.forEach((each) => each.highlight(null));
  part("tip").hidden = true;
}

for (const view of views) {
  view.canvas.addEventListener("pointermove", (event) => (event.buttons ? leave() : point(view, event)));
  view.canvas.addEventListener("pointerup", (event) => point(view, event));
  view.canvas.addEventListener("pointerleave", leave);
}
document.querySelectorAll("[data-from]").forEach((button) => {
  button.addEventListener("click", () => solid?.look(button.dataset.from));
});
part("copy").addEventListener("click", copyRecipe);
matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => plan.draw());
part("chooser").hidden = DATA.maps.length < 2;
part("maps").append(...DATA.maps.map((map, number) => Object.assign(element("option", map.name), { value: number })));
part("maps").addEventListener("change", (event) => choose(Number(event.target.value)));
choose(0);
window.rsegen = { solid, plan };
