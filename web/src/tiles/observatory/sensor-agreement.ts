/** Whether the sensors of a roof agree that it is closed; as the gateway judges it (gateway/safety/sensor_agreement.py). */

export interface RoofSensor {
  readonly name: string;
  readonly word: string;
  /** null when it says nothing. */
  readonly closed: boolean | null;
}

/**
 * Tells whether sensors contradict each other: within the whole, within one segment or flap, or the
 * whole and all segments, for it is closed exactly when all of them are.
 */
export function sensorsDisagree(
  whole: readonly RoofSensor[],
  segments: readonly (readonly RoofSensor[])[],
  others: readonly (readonly RoofSensor[])[] = [],
): boolean {
  if ([whole, ...segments, ...others].some(sensorsContradict)) return true;
  const [said, each] = [combinedState(whole), segments.map(combinedState)];
  return segments.length > 0 && said !== null && !each.includes(null) && said !== each.every((closed) => closed === true);
}

function sensorsContradict(sensors: readonly RoofSensor[]): boolean {
  return sensors.some(({ closed }) => closed === true) && sensors.some(({ closed }) => closed === false);
}

function combinedState(sensors: readonly RoofSensor[]): boolean | null {
  const said = new Set(sensors.map(({ closed }) => closed));
  return said.size === 1 ? ([...said][0] ?? null) : null;
}
