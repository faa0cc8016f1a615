// The verdicts of `thrustbench size`, worked out as bench/results/sizing.py, pauses.py, bands.py and machines.py do.
// Those files say why; a test holds this one to them.
"use strict";

const data = JSON.parse(document.getElementById("data").textContent);
const { late_share, close, chance, confidence, beyond } = data.constants;
const [FITS, WITHOUT_TAIL, MAY_FIT, DOES_NOT_FIT, UNKNOWN] = data.fits.keys();

function unpacked(singles) {
  const found = [];
  for (let i = 0, place = 0; i < singles.length; i += 2) {
    place += singles[i];
    found.push([data.times[place], singles[i + 1]]);
  }
  return found;
}

function merged(several) {
  const counts = new Map();
  for (const counted of several) for (const [ns, count] of counted) counts.set(ns, (counts.get(ns) ?? 0) + count);
  return [...counts].sort((a, b) => a[0] - b[0]);
}

const sum = (values) => values.reduce((a, b) => a + b, 0);
const total = (counted) => sum(counted.map(([, count]) => count));
const longerThan = (counted, ns) => sum(counted.map(([time, count]) => (time > ns ? count : 0)));
const most = (values) => values.reduce((a, b) => (b === null ? a : a === null ? b : Math.max(a, b)), null);

function quantile(counted, q) {
  const n = total(counted);
  if (!(n * (1 - q) > beyond - 1e-6)) return null;
  let below = 0;
  for (const [ns, count] of counted) if ((below += count) >= q * n) return ns;
  return counted.at(-1)[0];
}

function logGamma(x) {
  const c = [76.18009172947146, -86.50532032941677, 24.01409824083091, -1.231739572450155, 1.208650973866179e-3, -5.395239384953e-6];
  const t = x + 5.5;
  return (x + 0.5) * Math.log(t) - t + Math.log((2.5066282746310005 * c.reduce((s, v, i) => s + v / (x + 1 + i), 1.000000000190015)) / x);
}

// The regularised incomplete beta function I_x(a, b), by its continued fraction (Numerical Recipes, 6.4).
function beta(a, b, x) {
  if (x <= 0 || x >= 1) return x <= 0 ? 0 : 1;
  if (x > (a + 1) / (a + b + 2)) return 1 - beta(b, a, 1 - x);
  const tiny = 1e-300, safe = (v) => (Math.abs(v) < tiny ? tiny : v);
  let c = 1, d = 1 / safe(1 - ((a + b) * x) / (a + 1)), h = d;
  for (let m = 1; m < 10000; m++) {
    for (const step of [(m * (b - m) * x) / ((a + 2 * m - 1) * (a + 2 * m)), (-(a + m) * (a + b + m) * x) / ((a + 2 * m) * (a + 2 * m + 1))]) {
      d = 1 / safe(1 + step * d);
      c = safe(1 + step / c);
      h *= d * c;
    }
    if (Math.abs(d * c - 1) < 1e-14) break;
  }
  return (h / a) * Math.exp(logGamma(a + b) - logGamma(a) - logGamma(b) + a * Math.log(x) + b * Math.log1p(-x));
}

const bounds = new Map();
function lateBound(late, n) {
  const key = `${late}/${n}`;
  if (!bounds.has(key)) {
    let low = late / n, high = 1;
    if (late < n) for (let i = 0; i < 60; i++) beta(late + 1, n - late, (low + high) / 2) < confidence ? (low = (low + high) / 2) : (high = (low + high) / 2);
    bounds.set(key, high);
  }
  return bounds.get(key);
}

const pools = new Map();
function pool(method, demands) {
  if (!pools.has(method)) pools.set(method, new Map());
  const own = pools.get(method);
  if (!own.has(demands)) {
    const sets = method.sets.filter((set) => !demands || set.name === demands);
    const singles = merged(sets.map((set) => unpacked(set.singles)));
    own.set(demands, { sets, singles, calls: total(singles), took: sum(singles.map(([ns, count]) => ns * count)), tail: quantile(singles, 0.999) });
  }
  return own.get(demands);
}

function whose(pooled, late, limit, p50, steps, machine) {
  if (!late) return "";
  if (steps && (late === 1 || steps * p50 <= limit)) return "its steps are bounded, so the machine was late";
  const seen = longerThan(machine.excess, (limit - p50) * 1000);
  if (!seen || late > late_share * pooled.calls) return "";
  return beta(late, seen + 1, pooled.took / (pooled.took + machine.exposure_ns)) >= chance ? "fixed work was late as often, so the machine was" : "";
}

function judge(limit, p50, p999, slowest, bound) {
  if (p50 === null) return [UNKNOWN, "no call was timed"];
  if (p50 > limit) return [DOES_NOT_FIT, "median"];
  if (p999 !== null && p999 > limit) return [WITHOUT_TAIL, "p99.9"];
  if (slowest !== null && slowest > limit) return [WITHOUT_TAIL, "slowest call"];
  if (bound === null || bound > late_share) return [WITHOUT_TAIL, "too few calls"];
  return [FITS, ""];
}

// loop: {rate [Hz], budget [-], period and limit [us], clock [Hz]}
function sizeOf(machine, method, loop, demands) {
  const size = { ...method, data: method, machine: machine.name, fit: UNKNOWN, reason: "", exact: false, refused: 0, refusal: "", p50: null, cpu: null, p999: null, max: null, late: 0, calls: 0, bound: null, up_to: null, lost: null };
  if (machine.cpi) return counted(machine, size, loop);
  const pooled = pool(method, demands);
  const barred = pooled.sets.find((set) => set.failed) ?? pooled.sets.find((set) => set.wrong);
  size.lost = most(pooled.sets.filter((set) => demands || set.attainable).map((set) => set.lost));
  if (barred) return { ...size, reason: barred.failed || barred.wrong };
  const medians = pooled.sets.map((set) => set.p50_us);
  size.p50 = medians.length && !medians.includes(null) ? Math.max(...medians) : null;
  const cpu = pooled.sets.map((set) => set.cpu_us);
  size.cpu = cpu.length && !cpu.includes(null) ? Math.max(...cpu) : null;
  size.p999 = pooled.tail === null || size.p50 === null || pooled.tail / 1000 < size.p50 ? null : pooled.tail / 1000;
  size.max = pooled.calls ? pooled.singles.at(-1)[0] / 1000 : null;
  size.calls = pooled.calls;
  size.late = longerThan(pooled.singles, loop.limit * 1000);
  size.bound = pooled.calls ? lateBound(size.late, size.calls) : null;
  const excuse = size.p50 === null ? "" : whose(pooled, size.late, loop.limit, size.p50, method.steps, machine);
  [size.fit, size.reason] = excuse ? judge(loop.limit, size.p50, null, null, lateBound(0, size.calls)) : judge(loop.limit, size.p50, size.p999, size.max, size.bound);
  if (!size.reason && excuse) size.reason = excuse;
  const asked = pooled.sets.filter((set) => set.asked);
  size.exact = asked.every((set) => set.exact) && pooled.sets.some((set) => set.exact);
  const refusals = pooled.sets.filter((set) => set.refusal);
  if (refusals.length) ({ refused: size.refused, refusal: size.refusal } = refusals.reduce((a, b) => (b.refused > a.refused ? b : a)));
  const longest = size.max || size.p999 || size.p50;
  size.up_to = longest ? (loop.budget * 1e6) / longest : null;
  size.intervals = demands ? pooled.sets[0] : method;
  return size;
}

function counted(machine, size, loop) {
  const [low, high] = (size.data.cpi ?? machine.cpi).map((cycles) => ((size.instructions * cycles) / loop.clock) * loop.rate);
  const fit = high <= loop.budget ? FITS : low <= loop.budget ? MAY_FIT : DOES_NOT_FIT;
  size.fit = size.data.wrong || (size.missed && fit !== DOES_NOT_FIT) ? UNKNOWN : fit;
  size.reason = size.data.wrong || (size.missed ? `not counted: ${size.missed}` : `${three(100 * low)} to ${three(100 * high)} % by its instructions`);
  size.exact = size.data.exact && !size.data.wrong;
  size.p50 = size.cpu = high * loop.period;
  size.up_to = (loop.budget * 1e6) / size.p50;
  return size;
}

const median = (size) => size.cpu ?? size.p50 ?? 0;

function ordered(sizes) {
  const byText = (a, b) => (a < b ? -1 : a > b ? 1 : 0);
  const classes = new Map();
  for (const size of [...sizes].sort((a, b) => median(a) - median(b) || byText(a.label, b.label))) {
    const key = `${+(size.fit > MAY_FIT)}${+(size.refused > 0)}${+!size.exact}${size.fit}`;
    if (!classes.has(key)) classes.set(key, []);
    classes.get(key).push(size);
  }
  const found = [];
  for (const key of [...classes.keys()].sort()) {
    let left = classes.get(key);
    while (left.length) {
      const alike = left.filter((size) => median(size) <= close * median(left[0]));
      const group = alike.length ? alike : [left[0]];
      found.push(...group.filter((size) => size.steps !== null), ...group.filter((size) => size.steps === null));
      left = left.slice(group.length);
    }
  }
  return found;
}

function bestOfEach(sizes) {
  const seen = new Set();
  return sizes.filter((size) => !seen.has(size.method) && seen.add(size.method));
}

// What one method takes in the worst of several machines; those that not all of them have measured are left out.
function onAll(byMachine) {
  const places = byMachine.filter((sizes) => sizes.length);
  if (byMachine.length === 1) return ordered(byMachine[0]).map((size) => ({ ...size, there: [size] }));
  const found = [];
  for (const first of places[0] ?? []) {
    const there = places.map((sizes) => sizes.find((size) => size.label === first.label));
    if (there.includes(undefined)) continue;
    const worst = there.reduce((a, b) => (b.fit > a.fit ? b : a));
    const tails = there.map((size) => size.p999), rates = there.map((size) => size.up_to).filter((rate) => rate !== null);
    const worstOf = (key) => most(there.map((size) => size[key]));
    found.push({
      ...worst, there, reason: worst.reason ? `${worst.machine}: ${worst.reason}` : "", exact: there.every((size) => size.exact), refused: most(there.map((size) => size.refused)), refusal: there.reduce((a, b) => (b.refused > a.refused || (b.refused === a.refused && b.refusal > a.refusal) ? b : a)).refusal,
      p50: worstOf("p50"), cpu: worstOf("cpu"), p999: tails.includes(null) ? null : most(tails), max: worstOf("max"), late: sum(there.map((size) => size.late)), calls: sum(there.map((size) => size.calls)),
      bound: worstOf("bound"), up_to: rates.length ? Math.min(...rates) : null, memory_MB: worstOf("memory_MB"), lost: worstOf("lost"), served: there.map((size) => size.served).find(Boolean) ?? "",
    });
  }
  return ordered(found);
}

// Three significant digits, as bench/results/text.py prints them.
function three(value) {
  if (value === null || value === undefined) return "";
  if (value === 0) return "0";
  const rounded = Number(value.toPrecision(3));
  const digits = 2 - Math.floor(Math.log10(Math.abs(rounded)));
  return digits < -4 || digits > 5 ? rounded.toExponential(2).replace("+", "") : rounded.toFixed(Math.max(digits, 0));
}

// The sentence of bench/report/verdict.py.
function verdict(sizes, vehicle, loop, where) {
  const question = `${vehicle} at ${general(loop.rate)} Hz${where}`, first = sizes[0];
  const spoken = (size) => (size.twin ? `${size.twin} as generated C` : size.label);
  if (!first) return `${question}: nothing was measured.`;
  if (first.fit > MAY_FIT) {
    const times = sizes.filter((size) => size.fit === DOES_NOT_FIT && size.p50 !== null).map((size) => size.p50);
    const why = times.length ? `the fastest median is ${percent(Math.min(...times) / loop.period)} of the period` : "none has a time that counts";
    return `${question}: nothing here fits ${percent(loop.limit / loop.period)} of the period; ${why}.`;
  }
  const late = sizes.find((size) => size.exact && size.fit === DOES_NOT_FIT);
  const exactness = first.exact ? "exact" : `not exact (${late ? `${late.label}, which is, takes too long` : "no exact method was measured"})`;
  const exact = first.refusal ? `${exactness}, refuses ${first.refusal}` : sizes.some((size) => size.refused) ? `${exactness}, answers all` : exactness;
  const share = (first.p50 ?? 0) / loop.period;
  let text = `${question}: take ${spoken(first)}; ${exact}; ${share < 1e-4 ? "under 0.01 %" : percent(share)} of the period`;
  if (first.fit === WITHOUT_TAIL) text += `, its tail not shown to fit (${first.reason})`;
  if (first.fit === MAY_FIT) text += `, which may fit (${first.reason})`;
  const refusing = sizes.find((size) => size.exact && size.refused > first.refused);
  if (refusing) text += `; ${spoken(refusing)} refuses ${refusing.refusal}`;
  if (first.freedom === 0) text += "; no thruster to spare, so no freedom to gain from: a wrench can be made in one way";
  const alike = sizes.slice(1).filter((size) => size.fit === first.fit && size.exact === first.exact && size.refused > 0 === first.refused > 0 && size.method !== first.twin);
  const other = alike.find((size) => size.solver) ?? alike[0];
  return other ? `${text}; ${spoken(other)} would do too.` : `${text}.`;
}

const percent = (share) => (share === null ? "" : `${three(100 * share)} %`);
const general = (value) => String(Number(value.toPrecision(6)));
