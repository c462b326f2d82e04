import { describe, expect, it } from "vitest";
import { laneMark, laneOutline, offsetText } from "../../../src/elements/camera/lane-shape.js";

/** A camera that looks straight down: a metre is a tenth of the picture, ahead is up. */
const FROM_ABOVE = [0, -0.1, 0.5, -0.1, 0, 1, 0, 0, 1];

describe("the lane on a camera's picture", () => {
  it("has its markings to both sides of the vehicle", () => {
    const corners = laneOutline(FROM_ABOVE, [1, 3], { offset: 0, heading: 0, width: 2 });
    expect(corners.map(([x, y]) => [x.toFixed(3), y.toFixed(3)])).toEqual([
      ["0.400", "0.900"],
      ["0.400", "0.700"],
      ["0.600", "0.700"],
      ["0.600", "0.900"],
    ]);
  });

  it("lies to the right of a vehicle that is left of its middle", () => {
    const [nearLeft, , , nearRight] = laneOutline(FROM_ABOVE, [1, 3], { offset: 0.5, heading: 0, width: 2 });
    expect(((nearLeft?.[0] ?? 0) + (nearRight?.[0] ?? 0)) / 2).toBeCloseTo(0.55);
  });

  it("runs off to the right of a vehicle that is turned to the left", () => {
    const [nearLeft, farLeft] = laneOutline(FROM_ABOVE, [1, 3], { offset: 0, heading: 0.2, width: 2 });
    expect(farLeft?.[0] ?? 0).toBeGreaterThan(nearLeft?.[0] ?? 1);
  });

  it("is not drawn where a corner is behind the camera", () => {
    expect(laneMark([1, 0, 0, 0, 1, 0, -1, 0, 2], [1, 3], { offset: 0, heading: 0, width: 1 })).toBeNull();
  });

  it("says where the vehicle is as people do", () => {
    expect(offsetText(0.124)).toBe("12\u00a0cm left");
    expect(offsetText(-0.3)).toBe("30\u00a0cm right");
    expect(offsetText(0.003)).toBe("in the middle");
  });
});
