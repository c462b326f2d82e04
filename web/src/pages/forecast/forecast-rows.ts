/** A forecast of the week as a page shows it: chances of each request, the sky of each night, hours by proposal. Pure. */

import type { WeekNightShape, WeekShape } from "../../generated/api.js";
import type { NightSky } from "../../sky/night-sky.js";

/** A request that waits, with its chance in each night of the forecast (0 to 1). */
export interface ChanceRow {
  readonly id: string;
  readonly target: string;
  readonly proposal: string;
  readonly chances: readonly number[];
  readonly all: number;
}

/** The likeliest first; of equal ones by their names. */
export function chanceRows(nights: readonly WeekNightShape[]): readonly ChanceRow[] {
  const rows = new Map<string, { target: string; proposal: string; chances: number[] }>();
  nights.forEach(({ chances }, at) => {
    for (const { request, target, proposal, chance } of chances) {
      const row = rows.get(request) ?? { target, proposal, chances: nights.map(() => 0) };
      row.chances[at] = chance;
      rows.set(request, row);
    }
  });
  return [...rows]
    .map(([id, row]): ChanceRow => ({ id, ...row, all: row.chances.reduce((sum, chance) => sum + chance, 0) }))
    .sort((a, b) => b.all - a.all || a.target.localeCompare(b.target) || a.id.localeCompare(b.id));
}

/** What a proposal is expected to get in the nights of a forecast, beside what it has. */
export interface ExpectedShare {
  readonly id: string;
  readonly title: string;
  /** 0 to 1, of the shutter time; what is due. */
  readonly due: number;
  /** Block time in the mean (s). */
  readonly expectedS: number;
  /** 0 to 1, of all that is expected, others' too; NaN where nothing is. */
  readonly got: number;
  readonly leftS: number;
  readonly hours: number;
}

interface Allocated {
  readonly id: string;
  readonly title: string;
  readonly share: number;
  readonly hours_allocated: number;
  readonly used_s: number;
  readonly active: boolean;
}

/** Of others' blocks the chance is not told: they count as often as a roof is open. */
export function expectedShares({ nights, open_share: open }: WeekShape, proposals: readonly Allocated[]): readonly ExpectedShare[] {
  const expected = new Map<string, number>();
  let all = 0;
  for (const { plan, chances } of nights) {
    const chanceOf = new Map(chances.map(({ request, chance }) => [request, chance]));
    for (const { request, proposal, start_us: start, end_us: end } of plan.blocks) {
      const seconds = ((end - start) / 1e6) * (chanceOf.get(request) ?? open);
      all += seconds;
      if (proposal !== "") expected.set(proposal, (expected.get(proposal) ?? 0) + seconds);
    }
  }
  return proposals
    .filter(({ active, id }) => active || expected.has(id))
    .map(({ id, title, share, hours_allocated: hours, used_s: used }) => {
      const expectedS = expected.get(id) ?? 0;
      return { id, title, due: share, expectedS, got: all === 0 ? Number.NaN : expectedS / all, leftS: Math.max(0, hours * 3600 - used), hours };
    });
}

/** How long it is how dark, and when the Moon is up. */
export interface SkyFacts {
  /** Without any twilight (ms). */
  readonly darkMs: number;
  /** Of that without the Moon (ms). */
  readonly moonlessMs: number;
  /** 0 to 1. */
  readonly moonLit: number;
}

export function skyFacts({ bands, moonUp, moonLit }: NightSky): SkyFacts {
  const dark = bands.filter(({ id }) => id === "night");
  const darkMs = dark.reduce((sum, { from, to }) => sum + to - from, 0);
  const moonMs = dark.reduce((sum, band) => sum + moonUp.reduce((part, { from, to }) => part + Math.max(0, Math.min(to, band.to) - Math.max(from, band.from)), 0), 0);
  return { darkMs, moonlessMs: darkMs - moonMs, moonLit };
}
