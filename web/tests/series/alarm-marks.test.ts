import { expect, test } from "vitest";
import { AlarmMarks } from "../../src/series/alarm-marks.js";

const event = (time_us: number, device: string, kind = "alarm raised") => ({ time_us, device, kind, good: kind !== "alarm raised", message: "Low: 3 V" });

test("an alarm is marked on the charts of its device, one of the whole site on all", () => {
  const marks = new AlarmMarks();
  marks.add([event(3, "power"), event(1, ""), event(2, "base", "alarm cleared"), event(4, "base", "command asked")]);
  expect(marks.marksOf("power").map(({ timeUs }) => timeUs)).toEqual([1, 3]);
  expect(marks.marksOf("base")).toEqual([{ timeUs: 1, good: false, said: "Low raised" }, { timeUs: 2, good: true, said: "Low over" }]);
});

test("what is told and asked for alike is one mark, and the list is another only when there is more", () => {
  const marks = new AlarmMarks();
  marks.add([event(3, "power")]);
  const before = marks.marksOf("power");
  marks.add([event(3, "power")]);
  expect(marks.marksOf("power")).toBe(before);
  marks.add([event(5, "power")]);
  expect(marks.marksOf("power").map(({ timeUs }) => timeUs)).toEqual([3, 5]);
});
