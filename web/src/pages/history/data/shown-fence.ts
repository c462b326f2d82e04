/** Where outliers begin, in the unit that is shown. */

import { limitToShown } from "../../../format/unit.js";
import type { OutlierShape, ShownUnitShape } from "../../../generated/api.js";

// The same fence is the same object again: points are sought anew for another one only.
const converted = new WeakMap<OutlierShape, { readonly shown: ShownUnitShape; readonly fence: OutlierShape }>();

/** A fence that the hub found among stored values, as it lies among shown ones. */
export function shownFence(fence: OutlierShape, shown: ShownUnitShape | null): OutlierShape {
  if (shown === null) return fence;
  const held = converted.get(fence);
  if (held?.shown === shown) return held.fence;
  const [low, high] = [limitToShown(shown, fence.low), limitToShown(shown, fence.high)];
  const made = { ...fence, low, high, first: limitToShown(shown, fence.first), third: limitToShown(shown, fence.third) };
  converted.set(fence, { shown, fence: made });
  return made;
}
