/** The value axes of a chart: one for all its numbers, or one for each unit among them. */

import { msg } from "@lit/localize";
import { SteadyRange, type AxisRange } from "../../series/axis-range.js";
import type { TimeSpan } from "../../series/time-window.js";
import { valueExtent } from "./draw-series.js";
import type { ChartAxis, ChartSeries } from "./chart-model.js";
import type { AxisLook } from "./uplot-view.js";

export class ValueAxes {
  private readonly units: readonly string[];
  private readonly steady: readonly SteadyRange[];
  /** The same for charts that look the same beside their plots. */
  readonly key: string;
  readonly looks: readonly AxisLook[];

  /** @param many one for each unit, with the unit over it */
  constructor(series: readonly ChartSeries[], many: boolean, axis: ChartAxis) {
    const numbers = series.filter(({ states }) => states.length === 0);
    this.units = many ? [...new Set(numbers.map(({ unit }) => unit))] : [""];
    const bare = series.length > 0 && numbers.length === 0;
    this.looks = bare ? [] : this.units.map((unit) => (many ? lookOf(numbers, unit) : { title: "", colour: -1 }));
    this.steady = (this.units.length > 0 ? this.units : [""]).map(() => new SteadyRange(axis.limits, axis.least));
    this.key = JSON.stringify(this.looks);
  }

  /** What each axis covers; at least one. */
  axisRanges(series: readonly ChartSeries[], span: TimeSpan, columnUs: number): AxisRange[] {
    return this.steady.map((steady, i) => {
      const own = this.units.length < 2 ? series : series.filter(({ unit }) => unit === this.units[i]);
      const { min, max } = valueExtent(own, span, columnUs);
      return steady.nextRange(min, max);
    });
  }

  /** The place of a series' axis among all. */
  axisIndex({ unit }: ChartSeries): number {
    return this.units.length < 2 ? 0 : Math.max(0, this.units.indexOf(unit));
  }
}

// An axis that has one line to itself takes the line's colour.
function lookOf(numbers: readonly ChartSeries[], unit: string): AxisLook {
  const own = numbers.filter((series) => series.unit === unit);
  return { title: unit || msg("no unit"), colour: own.length === 1 ? (own[0]?.colour ?? -1) : -1 };
}
