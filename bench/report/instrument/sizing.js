// What `thrustbench size` says, looked up in tables that bench/report/html.py wrote; a test holds it to that.
"use strict";

const data = JSON.parse(document.getElementById("data").textContent);
const [FITS, WITHOUT_TAIL, MAY_FIT, DOES_NOT_FIT, UNKNOWN] = data.fits.keys();

const sum = (values) => values.reduce((a, b) => a + b, 0);
const most = (values) => values.reduce((a, b) => (b === null ? a : a === null ? b : Math.max(a, b)), null);

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

// loop: {rate [Hz], budget [-], period and limit [us], clock [Hz]}
function sizeOf(machine, method, loop, demands) {
  const size = { ...method, data: method, machine: machine.name, fit: UNKNOWN, reason: "", refused: 0, p50: null, cpu: null, p999: null, max: null, late: 0, calls: 0, bound: null, up_to: null, lost: null };
  if (machine.cpi) return counted(machine, size, loop);
  const pool = method.pools.find((own) => own.demands === demands);
  Object.assign(size, pool);
  [, size.fit, size.reason, size.usefulness] = pool.verdicts.findLast(([from]) => from <= loop.limit);
  if (pool.calls) {
    pool.sorted ??= singlesOf(method, demands);
    const late = pool.sorted.filter(([ns]) => ns / 1000 > loop.limit);
    size.late = sum(late.map(([, count]) => count));
    size.bound = pool.bounds[pool.sorted.length - late.length - 1] ?? 100;
  }
  size.up_to = size.max ? (loop.budget * 1e6) / size.max : null;
  return size;
}

function counted(machine, size, loop) {
  const [low, high] = (size.data.cpi ?? machine.cpi).map((cycles) => ((size.instructions * cycles) / loop.clock) * loop.rate);
  const fit = high <= loop.budget ? FITS : low <= loop.budget ? MAY_FIT : DOES_NOT_FIT;
  size.fit = size.wrong || (size.misses && fit !== DOES_NOT_FIT) ? UNKNOWN : fit;
  size.reason = size.wrong || (size.misses ? `not counted: ${size.misses}` : `${three(100 * low)} to ${three(100 * high)} % by its instructions`);
  size.usefulness = size.data.usefulness[size.fit];
  size.p50 = size.cpu = high * loop.period;
  size.up_to = (loop.budget * 1e6) / size.p50;
  return size;
}

// The order is Python's, Size.usefulness and Size.precedence: lists of numbers, least first. Here they are walked.
const byNumbers = (a, b) => a.map((value, i) => value - b[i]).find(Boolean) ?? 0;
const worst = (lists) => lists.reduce((a, b) => a.map((value, i) => Math.max(value, b[i])));
const byName = (a, b) => (a === b ? 0 : a.length - b.length || (a < b ? -1 : 1));
const byPlace = (a, b) => byNumbers(a.precedence, b.precedence) || byName(a.method, b.method) || median(a) - median(b) || (a.label < b.label ? -1 : 1);
const median = (size) => size.cpu ?? size.p50 ?? 0;
const alike = (a, b) => byNumbers(a.usefulness, b.usefulness) === 0;

function ordered(sizes, loop) {
  let left = [...sizes].sort((a, b) => byNumbers(a.usefulness, b.usefulness) || median(a) - median(b));
  const found = [];
  while (left.length) {
    const least = median(left[0]), equal = Math.max(data.close * least, least + data.spare * loop.period);
    const close = left.filter((size) => alike(size, left[0]) && median(size) <= equal);
    left = left.slice(close.length);
    found.push(...close.sort(byPlace));
  }
  return found;
}

// Another that a longer run may put first, or second: possible_first of bench/results/size.py, and its neighbours.
const tenths = (missing) => data.edges.filter((edge) => missing > edge).length;
const ONES = [0, 1, 1, 2, 1, 2, 2, 3, 1, 2, 2, 3, 2, 3, 3, 4]; // bits of a digit of 16

function mostMissing(size, rival, missing) {
  const n = Math.min(size.n_even, rival.n_even), [, own, high] = size.missing, its = rival.missing[1];
  let equal = own === 0 && its === 0, margin = 0;
  if (size.misses && size.misses.length === rival.misses.length) {
    const differ = sum([...size.misses].map((digit, i) => ONES[Number.parseInt(digit, 16) ^ Number.parseInt(rival.misses[i], 16)]));
    equal ||= !differ;
    margin = differ && n ? (data.certain * Math.sqrt(differ) + 1) / n : 0;
  }
  return size.exact || !(equal || margin) ? high : Math.min(Math.max(missing + (own - its + margin), 0), 1);
}

function reading(size, loop, missing, better) {
  const factor = size.calls ? (better ? 1 / data.close : data.close) : 1;
  let fit = size.fit;
  if (size.p50 !== null && [FITS, WITHOUT_TAIL, DOES_NOT_FIT].includes(fit)) {
    if (factor * size.p50 > loop.limit) fit = DOES_NOT_FIT;
    else if (fit === DOES_NOT_FIT) fit = WITHOUT_TAIL;
  }
  const gap = (better ? Math.min : Math.max)(size.gap, size.other_gap ?? size.gap), [, , inexact, , tail] = size.usefulness, late = fit > WITHOUT_TAIL ? fit - 1 : better || size.fit > WITHOUT_TAIL ? 0 : tail;
  return { ...size, p50: null, cpu: factor * median(size), usefulness: [Number(fit > MAY_FIT), gap, inexact, tenths(missing), late], precedence: [...size.precedence.slice(0, -1), tenths(missing) ? missing : 0] };
}

function possibleFirst(sizes, loop) {
  const comesFirst = (rival, missing) => {
    const best = reading(rival, loop, missing, true), worse = (size) => reading(size, loop, mostMissing(size, rival, missing), false);
    if (byNumbers(best.usefulness, worse(sizes[0]).usefulness) > 0) return false; // so for most, and the rest takes time
    return ordered(sizes.map((size) => (size === rival ? best : worse(size))), loop)[0] === best;
  };
  return sizes.slice(1).find((rival) => {
    const [low, , high] = rival.missing, between = data.edges.filter((edge) => low < edge && edge < high);
    return [...rival.missing, ...between].some((missing) => comesFirst(rival, missing));
  });
}

const others = ([first, ...rest]) => rest.filter((size) => size.method !== first.twin && (first.refusal || !size.refusal));

function bestOfEach(sizes) {
  const seen = new Set();
  return sizes.filter((size) => !seen.has(size.method) && seen.add(size.method));
}

// What one method takes in the worst of several machines; those that not all of them have measured are left out.
function onAll(byMachine, loop) {
  const places = byMachine.filter((sizes) => sizes.length);
  if (byMachine.length === 1) return ordered(byMachine[0], loop).map((size) => ({ ...size, there: [size] }));
  const found = [];
  for (const first of places[0] ?? []) {
    const there = places.map((sizes) => sizes.find((size) => size.label === first.label));
    if (there.includes(undefined)) continue;
    const unfit = there.reduce((a, b) => (b.fit > a.fit ? b : a)), refusing = there.reduce((a, b) => (b.refused > a.refused || (b.refused === a.refused && b.refusal > a.refusal) ? b : a));
    const tails = there.map((size) => size.p999), rates = there.map((size) => size.up_to).filter((rate) => rate !== null);
    const largest = ["refused", "gap", "p50", "cpu", "max", "bound", "memory_MB", "lost", "other_gap"].map((key) => [key, most(there.map((size) => size[key]))]);
    found.push({
      ...unfit, ...Object.fromEntries(largest), there, reason: unfit.reason ? `${unfit.machine}: ${unfit.reason}` : "", exact: there.every((size) => size.exact), picky: there.some((size) => size.picky), refusal: refusing.refusal,
      usefulness: worst(there.map((size) => size.usefulness)), precedence: worst(there.map((size) => size.precedence)), missing: worst(there.map((size) => size.missing)), n_even: Math.min(...there.map((size) => size.n_even)), misses: there.every((size) => size.misses === unfit.misses) ? unfit.misses : "",
      p999: tails.includes(null) ? null : most(tails), late: sum(there.map((size) => size.late)), calls: sum(there.map((size) => size.calls)),
      up_to: rates.length ? Math.min(...rates) : null, served: there.map((size) => size.served).find(Boolean) ?? "",
    });
  }
  return ordered(found, loop);
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
  if (!first) return `${question}: nothing was measured.`;
  if (first.fit > MAY_FIT) {
    const times = sizes.filter((size) => size.fit === DOES_NOT_FIT && size.p50 !== null).map((size) => size.p50);
    const why = times.length ? `the fastest median is ${percent(Math.min(...times) / loop.period)} of the period` : "none has a time that counts";
    return `${question}: nothing here fits ${percent(loop.limit / loop.period)} of the period; ${why}.`;
  }
  if (first.refused >= 1) return `${question}: nothing to take: ${first.spoken} refuses ${first.refusal}${first.part ? ` (${first.part})` : ""}.`;
  const late = sizes.find((size) => size.exact && size.fit === DOES_NOT_FIT), picky = sizes.find((size) => size.exact && size.refused && size.fit <= MAY_FIT);
  const inexact = picky ? `${picky.spoken} is exact but refuses some demands` : late ? `${late.label} is exact but too slow` : "no exact method was measured";
  const exactness = (first.exact ? "exact" : `not exact (${inexact})`) + (first.unlimited ? ", knows no limits" : "");
  const exact = first.refusal ? `${exactness}, refuses ${first.refusal}` : !first.gap && sizes.some((size) => size.gap) ? `${exactness}, answers every demand` : exactness;
  const share = (first.p50 ?? 0) / loop.period;
  let text = `${question}: take ${first.spoken}; ${exact}; ${share < 1e-4 ? "under 0.01 %" : percent(share)} of the period`;
  if (first.fit === WITHOUT_TAIL) text += `, its tail not shown to fit (${first.reason})`;
  if (first.fit === MAY_FIT) text += `, which may fit (${first.reason})`;
  // Where another such method answers all that the first does, who refuses more has given up.
  const exacting = sizes.filter((size) => size.picky), refusing = exacting[0];
  if (refusing && exacting.every((size) => byNumbers([size.gap, size.refused], [first.gap, first.refused]) > 0)) text += `; ${refusing.spoken} refuses ${refusing.refusal}`;
  if (first.freedom === 0) text += "; no spare thruster: each wrench has one solution";
  if (first.part) text += `; ${first.part}`;
  const rival = possibleFirst(sizes, loop);
  if (rival) text += `; not decided by so few: ${rival.spoken} may come first`;
  const [other] = others(sizes);
  if (!other || !alike(other, first)) return `${text}.`;
  const instead = rival ? undefined : possibleFirst(others(sizes), loop);
  return `${text}; ${other.spoken} would do too${instead ? `, or ${instead.spoken}: not decided by so few` : ""}.`;
}

const percent = (share) => (share === null ? "" : `${three(100 * share)} %`);
const general = (value) => String(Number(value.toPrecision(6)));
