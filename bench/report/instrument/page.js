// The page: choices in, verdict, table and pictures out. What is said of a loop is looked up: bench/report/html.py.
"use strict";

const data = JSON.parse(document.getElementById("data").textContent);
const UNKNOWN = data.fits.length - 1;
const by = (id) => document.getElementById(id);
const element = (name, text, attributes = {}) => Object.assign(document.createElement(name), { textContent: text }, attributes);
const names = (of) => [...new Set(data.machines.flatMap((machine) => machine.methods.map(of)))];

const DEFAULTS = { vehicle: names((m) => m.vehicle).sort()[0] ?? "", ...data.opening, formulation: "", demands: "", exact: "", every: "", filter: "", sort: "", pick: "", machine: "" };
const LOOP = ["rate", "budget", "clock"];
const state = { ...DEFAULTS };
let shown = [];

function choice(select, pairs) {
  select.replaceChildren(...pairs.map(([value, text]) => element("option", text, { value })));
}

function build() {
  choice(by("vehicle"), names((m) => m.vehicle).sort().map((name) => [name, data.frames[name] ? `${name} (${data.frames[name].split(":")[0]})` : name]));
  choice(by("formulation"), [["", "any"], ...Object.entries(data.formulations).map(([name, title]) => [name, title.startsWith("a rule ") ? `${name}: ${title}` : title])]);
  choice(by("demands"), [["", "all kinds"], ...data.sets.map((name) => [name, name])]);
  choice(by("machine"), [...(data.machines.length > 1 ? [["", "all together"]] : []), ...data.machines.map((machine, i) => [data.machines.length > 1 ? i : "", machine.name])]);
  for (const id of LOOP) choice(by(id), data[id].map((value) => [value, general(value)]));
  by("machine").parentElement.hidden = data.machines.length < 2;
  by("clock-choice").hidden = data.machines.every((machine) => machine.timed);
  for (const id of ["vehicle", "formulation", "demands", "machine"]) by(id).onchange = () => set({ [id]: by(id).value });
  for (const id of LOOP) by(id).onchange = () => set({ [id]: Number(by(id).value) });
  for (const id of ["exact", "every"]) by(id).onchange = () => set({ [id]: by(id).checked ? "1" : "" });
  by("filter").oninput = () => set({ filter: by("filter").value });
  document.querySelectorAll("form").forEach((form) => (form.onsubmit = (event) => event.preventDefault()));
  by("copy").onclick = copy;
  window.onhashchange = read;
  by("instrument").hidden = false;
}

// The address keeps what differs from the defaults, so that a link shows what was seen.
function read() {
  const asked = Object.fromEntries(new URLSearchParams(location.hash.slice(1)));
  Object.assign(state, DEFAULTS, Object.fromEntries(Object.entries(asked).filter(([key]) => key in DEFAULTS)));
  // What is not offered is read as the nearest that is.
  for (const key of LOOP) state[key] = !(state[key] > 0) ? DEFAULTS[key] : data[key].reduce((a, b) => (Math.abs(Math.log(b / state[key])) < Math.abs(Math.log(a / state[key])) ? b : a));
  if (!names((m) => m.vehicle).includes(state.vehicle)) state.vehicle = DEFAULTS.vehicle;
  update();
}

function set(changes) {
  Object.assign(state, changes);
  const kept = Object.entries(state).filter(([key, value]) => String(value) !== String(DEFAULTS[key]));
  history.replaceState(null, "", kept.length ? `#${new URLSearchParams(kept)}` : location.pathname + location.search);
  update();
}

function update() {
  for (const id of ["vehicle", "formulation", "demands", "machine", "filter", ...LOOP]) by(id).value = state[id];
  for (const id of ["exact", "every"]) by(id).checked = Boolean(state[id]);
  const loop = loopOf(), machines = chosenMachines(), [words, order] = answer();
  const there = machines.map((machine) => machine.methods.filter((m) => m.vehicle === state.vehicle).map((m) => sizeOf(machine, m, loop)).filter(Boolean)).filter((sizes) => sizes.length);
  const every = order.map((label) => onAll(there.map((sizes) => sizes.find((size) => size.label === label))));
  const ranked = state.every ? every : every.filter((size, i) => every.findIndex((other) => other.method === size.method) === i);
  by("verdict").textContent = `${state.vehicle} at ${general(loop.rate)} Hz${machines.length > 1 ? " on every machine that has it" : ""}: ${words}`;
  const kind = state.formulation ? data.formulations[state.formulation] : "any";
  by("asked").textContent = `A call may take ${three(loop.limit)} µs, ${percent(loop.budget)} of the period. Listed: ${kind}${state.exact ? ", exact ones only" : ""}; demands: ${state.demands || "all kinds"}${data.frames[state.vehicle] ? `, in ${data.frames[state.vehicle]}` : ""}.`;
  const inPart = new Set(there.flat().map((size) => size.method)).size - new Set(every.map((size) => size.method)).size;
  by("in-part").textContent = inPart ? `${inPart} ${inPart === 1 ? "method is" : "methods are"} left out, not measured on every machine: choose one machine to see its own.` : "";
  by("sure").replaceChildren(...machines.map((machine) => element("li", `${machine.name} ${machine.sure}`)));
  shown = ranked.filter(wanted).filter((size) => matches(size, state.filter));
  table(by("table"), columns(machines, loop), shown);
  const alike = {};
  for (const size of shown.filter((size) => size.fit === UNKNOWN)) (alike[size.reason.replace(`${size.method}: `, "")] ??= []).push(size.label);
  by("unknown").replaceChildren(...Object.entries(alike).map(([reason, labels]) => element("li", `${labels.join(", ")}: ${reason}`)));
  facts(picked(ranked), loop);
  if (window.vegaEmbed) draw();
}

const loopOf = () => ({ rate: state.rate, budget: state.budget / 100, period: 1e6 / state.rate, limit: (state.budget / 100) * (1e6 / state.rate), clock: state.clock });

// The places of the chosen loop among rates and budgets, and among these and clocks.
function place() {
  const [rate, budget, clock] = LOOP.map((key) => data[key].indexOf(state[key]));
  const at = rate * data.budget.length + budget;
  return [at, clock * data.limits.length + at];
}

const chosenMachines = () => (data.machines[state.machine] ? [data.machines[state.machine]] : data.machines);

// The sentence and the order of labels for the chosen loop.
function answer() {
  const one = data.answers[state.machine] ?? data.answers.at(-1);
  const outcomes = (one?.[state.demands] ?? one?.[""])?.[state.vehicle];
  if (!outcomes) return ["nothing was measured.", []];
  const [at, clocked] = place();
  const [words, order] = data.outcomes[outcomes[outcomes.length > data.limits.length ? clocked : at]];
  return [words.map((i) => data.words[i]).join(". "), data.orders[order].map((i) => data.labels[i])];
}

function sizeOf(machine, method, loop) {
  const [at, clocked] = place();
  if (!machine.timed) {
    const fit = Number(method.fits[clocked]), [least, p50] = method.cycles.map((cycles) => cycles / loop.clock);
    return { ...method, data: method, machine: machine.name, fit, reason: fit === UNKNOWN ? method.reason : "", least, p50, p999: null, max: null, calls: 0, up_to: (1e6 * loop.budget) / p50, lost: null };
  }
  const pool = method.pools.find((own) => own.demands === state.demands);
  if (!pool) return null;
  const [fit, reason, late, bound] = data.judged[pool.at[data.limits[at]]];
  return { ...method, ...pool, data: method, machine: machine.name, fit, reason, late, bound, up_to: pool.max ? (1e6 * loop.budget) / pool.max : null };
}

// One method on all machines: its worst verdict.
function onAll(there) {
  const [first] = there;
  if (there.length < 2) return { ...first, there };
  const unfit = there.reduce((a, b) => (b.fit > a.fit ? b : a));
  return { ...first, there, fit: unfit.fit, reason: unfit.reason && `${unfit.machine}: ${unfit.reason}`, exact: there.every((size) => size.exact), lost: there.map((size) => size.lost).reduce((a, b) => (a === null || b > a ? b : a)), served: there.map((size) => size.served).find(Boolean) ?? "" };
}

// The single calls on one demand set, or on all: [time [ns], how often], sorted.
function singlesOf(method, demands) {
  const counts = new Map();
  for (const { singles } of method.pools.filter((pool) => pool.singles && (!demands || pool.demands === demands)))
    for (let i = 0, place = 0; i < singles.length; i += 2) {
      const ns = data.times[(place += singles[i])];
      counts.set(ns, (counts.get(ns) ?? 0) + singles[i + 1]);
    }
  return [...counts].sort((a, b) => a[0] - b[0]);
}

// Three significant digits, as bench/results/text.py prints them.
function three(value) {
  if (value === null || value === undefined) return "";
  if (value === 0) return "0";
  const rounded = Number(value.toPrecision(3));
  const digits = 2 - Math.floor(Math.log10(Math.abs(rounded)));
  return digits < -4 || digits > 5 ? rounded.toExponential(2).replace("+", "") : rounded.toFixed(Math.max(digits, 0));
}

const percent = (share) => (share === null ? "" : `${three(100 * share)} %`);
const general = (value) => String(Number(value.toPrecision(6)));
const wanted = (size) => (!state.exact || size.exact) && (!state.formulation || size.formulation === state.formulation);
const matches = (size, text) => !text || [size.label, size.family, data.fits[size.fit], size.reason].join(" ").toLowerCase().includes(text.toLowerCase());

// Methods side by side: those chosen, else the first and the first without limits.
function picked(ranked) {
  const labels = state.pick ? state.pick.split("|") : [];
  const chosen = labels.map((label) => ranked.find((size) => size.label === label)).filter(Boolean);
  return chosen.length ? chosen : [...new Set([ranked[0], ranked.find((size) => size.unlimited && size.fit !== UNKNOWN)])].filter(Boolean);
}

function pick(label) {
  const labels = state.pick ? state.pick.split("|") : [];
  set({ pick: (labels.includes(label) ? labels.filter((other) => other !== label) : [...labels, label].slice(-4)).join("|") });
}

// A column: its heading, the text of a cell, and the value to sort by where that is not the text.
function columns(machines, loop) {
  const share = (us) => three(us === null || us === undefined ? null : (100 * us) / loop.period);
  const known = (size) => size.fit !== UNKNOWN;
  const head = [
    ["method", (s) => s.label],
    ["verdict", (s) => data.fits[s.fit], (s) => s.fit],
    ["exact", (s) => (known(s) ? (s.exact ? "yes" : "no") : "")],
  ];
  const tail = [
    ["lost [%]", (s) => three(s.lost === null ? null : s.lost < 1e-6 ? 0 : 100 * s.lost), (s) => s.lost],
    ["served", (s) => s.served, (s) => parseFloat(s.served)],
    ["kind", (s) => s.family],
  ];
  if (machines.length > 1) {
    const each = machines.flatMap((machine) => {
      const own = (s) => s.there.find((size) => size.machine === machine.name);
      return [[machine.name, (s) => (own(s) ? data.fits[own(s).fit] : ""), (s) => own(s)?.fit], [machine.timed ? "median [%]" : "at most [%]", (s) => share(own(s)?.p50), (s) => own(s)?.p50]];
    });
    return [...head, ...each, ["why", (s) => s.reason], ...tail];
  }
  const timed = machines[0]?.timed ?? true, times = timed ? [["median [%]", "p50"], ["p99.9 [%]", "p999"], ["slowest [%]", "max"]] : [["at least [%]", "least"], ["at most [%]", "p50"]];
  return [
    ...head.slice(0, 2),
    ["why", (s) => (known(s) ? s.reason : "see below")],
    head[2],
    ...times.map(([name, key]) => [name, (s) => share(s[key]), (s) => s[key]]),
    ...tail.slice(0, timed ? 2 : 0),
    ...(timed ? [["late", (s) => (s.calls ? `${s.late} of ${s.calls}` : ""), (s) => s.late], ["late ≤ [%]", (s) => three(s.bound), (s) => s.bound]] : []),
    ["up to [Hz]", (s) => three(s.up_to), (s) => s.up_to],
    ...(timed ? [["memory [MB]", (s) => three(known(s) ? s.memory_MB : null), (s) => s.memory_MB]] : []),
    tail[2],
  ];
}

const numeric = (name) => name.endsWith("]") || ["late", "served"].includes(name);

function table(target, cols, rows) {
  const [at, falling] = state.sort ? [Math.abs(state.sort) - 1, state.sort < 0] : [-1, false];
  if (cols[at]) {
    const value = cols[at][2] ?? cols[at][1];
    const empty = (v) => v === null || v === undefined || v === "" || Number.isNaN(v);
    rows = [...rows].sort((a, b) => {
      const x = value(a), y = value(b);
      if (empty(x) || empty(y)) return empty(x) - empty(y);
      return (x < y ? -1 : x > y ? 1 : 0) * (falling ? -1 : 1);
    });
  }
  shown = rows;
  const head = element("tr", "");
  cols.forEach(([name], i) => {
    const cell = element("th", "", { scope: "col", className: numeric(name) ? "number" : "", ariaSort: at === i ? (falling ? "descending" : "ascending") : "none" });
    const arrow = at === i ? (falling ? " ▼" : " ▲") : "";
    cell.append(element("button", name + arrow, { type: "button", title: "Sort", onclick: () => { set({ sort: at !== i ? i + 1 : falling ? "" : -(i + 1) }); by("table").querySelectorAll("th button")[i].focus(); } }));
    head.append(cell);
  });
  target.tHead.replaceChildren(head);
  const labels = state.pick ? state.pick.split("|") : [];
  target.tBodies[0].replaceChildren(...rows.map((size) => {
    const row = element("tr", "", { ariaSelected: String(labels.includes(size.label)) });
    cols.forEach(([name, text], i) => {
      const cell = element("td", i ? text(size) : "", { className: numeric(name) ? "number" : "" });
      cell.dataset.label = name;
      if (!i) cell.append(element("button", text(size), { type: "button", title: "Put beside others", ariaPressed: row.ariaSelected, onclick: () => { pick(size.label); focusRow(size.label); } }));
      row.append(cell);
    });
    return row;
  }));
}

function focusRow(label) {
  [...by("table").tBodies[0].querySelectorAll("button")].find((button) => button.textContent === label)?.focus();
}

async function copy() {
  const quoted = (text) => (/[",\n]/.test(text) ? `"${text.replaceAll('"', '""')}"` : text);
  const cols = columns(chosenMachines(), loopOf());
  const text = [cols.map(([name]) => name), ...shown.map((size) => cols.map(([, cell]) => String(cell(size))))].map((line) => line.map(quoted).join(",")).join("\n") + "\n";
  try {
    await navigator.clipboard.writeText(text);
    by("copied").textContent = `${shown.length} rows copied`;
  } catch {
    const area = element("textarea", text);
    document.body.append(area);
    area.select();
    by("copied").textContent = document.execCommand("copy") ? `${shown.length} rows copied` : "this browser does not let a page copy";
    area.remove();
  }
}

const range = (pair) => (Number.isFinite(pair?.[0]) ? ` (${three(pair[0])} … ${three(pair[1])})` : "");

// Of all kinds of demands together nobody delivers those that can't be met, so they tell nothing.
const lostOf = ({ lost }) => lost === null || lost === undefined ? "" : percent(lost < 1e-6 ? 0 : lost) + (state.demands ? "" : " of what can be met");

function facts(chosen, loop) {
  const lines = [
    ["verdict", (s) => [data.fits[s.fit], s.reason].filter(Boolean).join("; ")],
    ["machine", (s) => s.machine],
    ["answers", (s) => data.formulations[s.formulation] ?? s.formulation],
    ["exact", (s) => (s.exact ? "yes" : "no")],
    ["kind", (s) => s.family],
    ["solver", (s) => s.solver],
    ["median [µs]", (s) => three(s.p50) + range(s.p50_range)],
    ["p99.9 [µs]", (s) => three(s.p999) + range(s.p999_range)],
    ["slowest [µs]", (s) => three(s.max)],
    ["set-up [µs]", (s) => three(s.data.setup_us)],
    ["worst case [steps]", (s) => String(s.steps ?? "not known")],
    ["iterations, most", (s) => String(s.data.iterations || "")],
    ["instructions, most", (s) => String(s.data.instructions ?? "")],
    ["from the optimum, over the largest limit", (s) => three(s.data.distance)],
    ["promised", (s) => three(s.data.promise)],
    ["allocator [kB]", (s) => three(s.data.allocator_kB)],
    ["process [MB]", (s) => three(s.memory_MB)],
    ["wrench lost, worst", lostOf],
    ["served", (s) => s.served],
  ];
  const sizes = chosen.flatMap((size) => size.there ?? [size]);
  by("facts").tHead.replaceChildren(rowOf("th", ["", ...sizes.map((size) => size.label)]));
  by("facts").tBodies[0].replaceChildren(...lines.map(([name, text]) => [name, ...sizes.map(text)]).filter((line) => line.slice(1).some(Boolean)).map((line) => rowOf("td", line)));
  by("facts").querySelectorAll("td").forEach((cell) => (cell.dataset.label = sizes[cell.cellIndex - 1].label));
}

function rowOf(kind, texts) {
  const row = element("tr", "");
  row.append(...texts.map((text, i) => element(i ? kind : "th", text, { scope: i ? (kind === "th" ? "col" : "") : "row" })));
  return row;
}

const views = {};
const charts = JSON.parse(by("charts").textContent);
if (data.machines.length < 2) charts.cost.layer.forEach((layer) => delete layer.encoding.shape);
// A legend names what is drawn: of the families, those of these rows. An axis has a domain and no range.
const named = (chart, rows) => JSON.parse(JSON.stringify(chart), (key, value) => {
  if (key !== "scale" || !value?.domain || !value.range) return value;
  const kept = value.domain.map((_, i) => i).filter((i) => rows.some((row) => row.family === value.domain[i]));
  return { ...value, domain: kept.map((i) => value.domain[i]), range: kept.map((i) => value.range[i]) };
});
async function show(id, rows, more = {}) {
  const place = by(id).closest(".halves > div") ?? by(id).closest("section");
  place.hidden = !rows.length; // a logarithmic axis needs a point, and a heading something under it
  if (!rows.length) return;
  const families = [...new Set(rows.map((row) => row.family))].sort().join();
  if (by(id).dataset.families !== families) delete views[id];
  by(id).dataset.families = families;
  views[id] ??= vegaEmbed(by(id), { ...named(charts[id], rows), datasets: { rows, ...more } }, { actions: false, renderer: "svg", tooltip: { theme: "custom" } }).then(({ view }) => {
    view.addEventListener("click", (event, item) => item?.datum?.label && pick(item.datum.label));
    return view;
  });
  const view = await views[id];
  for (const [name, values] of Object.entries({ rows, ...more })) view.data(name, values);
  await view.resize().runAsync();
}

const MOST = 16;
async function draw() {
  const loop = loopOf(), several = chosenMachines().length > 1;
  const points = shown.flatMap((size, rank) => (size.there ?? [size]).filter((own) => own.p50).map((own) => ({
    label: own.label, rank, machine: own.machine, family: own.family, verdict: data.fits[own.fit], p50: own.p50, p999: own.p999, max: own.max, loss: own.lost === null || own.lost === undefined ? null : Math.max(own.lost, 1e-6),
    "median": `${three(own.p50)} µs${range(own.p50_range)}`, "p99.9": own.p999 === null ? "too few calls" : `${three(own.p999)} µs${range(own.p999_range)}`, "slowest": own.max === null ? "-" : `${three(own.max)} µs`,
    "wrench lost, worst": lostOf(own) || "-", "served": own.served || "-",
  })));
  const chosen = picked(shown);
  by("more").textContent = shown.length > MOST ? `The first ${MOST} of ${shown.length} are drawn, and those that you choose.` : "";
  const tails = chosen.flatMap((size) => (size.there ?? [size])).filter((own) => own.calls).flatMap((own) => tailOf(own, several));
  const curves = chosen.flatMap((size) => curvesOf(size));
  by("curves-none").textContent = curves.length ? "" : "No curve was measured for these: an exact solver's is that of nullspace.";
  await Promise.all([
    show("cost", points.filter((point) => point.rank < MOST || chosen.some((size) => size.label === point.label)), { limit: [{ limit: loop.limit }] }),
    show("trade", points.filter((point) => point.loss !== null)),
    show("tails", tails, { limit: [{ limit: loop.limit }] }),
    show("curves", curves),
  ]);
  document.body.dataset.drawn = String(Number(document.body.dataset.drawn ?? 0) + 1);
}

function tailOf(own, several) {
  let left = own.calls;
  return singlesOf(own.data, state.demands).map(([ns, count]) => {
    const share = left / own.calls;
    left -= count;
    return { name: several ? `${own.label}, ${own.machine}` : own.label, label: own.label, us: ns / 1000, share };
  });
}

function curvesOf(size) {
  const all = data.machines.map((machine) => machine.curves?.[size.vehicle] ?? []).find((curves) => curves.length) ?? [];
  const curve = all.find((own) => own.method === size.method || own.method === size.twin);
  if (!curve) return [];
  return curve.size.flatMap((at, i) => [["median direction", curve.p50[i]], ["worst direction", curve.max[i]]].map(([direction, missed]) => ({ name: size.label, label: size.label, size: at, direction, missed })));
}

build();
read();
