import type { Anomaly } from "../../state/anomaly-detectors.js";
import type { ChartMark } from "./draw-marks.js";

/** Anomalies as marks on a chart; those that a person has said are none look well. */
export function anomalyMarks(anomalies: readonly Anomaly[]): readonly ChartMark[] {
  return anomalies.map(({ fromUs, toUs, forgiven }) => ({ timeUs: fromUs, untilUs: toUs, good: forgiven }));
}
