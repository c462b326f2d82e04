import { expect, test } from "vitest";
import type { CommandRole, CommandShape, DeviceShape, SignalShape } from "../../../src/generated/api.js";
import { NO_DEVICE } from "../../../src/tiles/observatory/device-part.js";
import { presetNames, ptzButtons, ptzParts } from "../../../src/tiles/ptz/ptz-parts.js";

function command(id: string, role: CommandRole, argument = ""): CommandShape {
  const args = argument === "" ? [] : [{ id: argument, name: argument, type: "text" as const, unit: "", minimum: null, maximum: null, max_length: 64, default: null }];
  return { id, name: id, role, description: "", confirm: false, timeout: 5, cancellable: true, arguments: args, needs: null, ros: "" };
}
const PRESETS: SignalShape = {
  id: "presets", address: "gate/presets", name: "Presets", type: "text", role: "camera.presets", unit: "", decimals: -1, minimum: null, maximum: null,
  states: [], meanings: [], frame: "", max_age: 0, primary: false, public: false, ros: "", channels: ["gate/presets"], shown: null,
};
const GATE: DeviceShape = {
  ...NO_DEVICE,
  id: "gate",
  kind: "camera",
  signals: [PRESETS],
  commands: [command("go", "camera.goto_preset", "place"), command("home", "camera.home"), command("stop", "camera.abort"), command("keep", "camera.set_preset", "name")],
};

test("presets are one a line; empty and repeated ones are none", () => {
  expect(presetNames("Gate\n\n Yard \nGate\n")).toEqual(["Gate", "Yard"]);
  expect(presetNames("")).toEqual([]);
  expect(presetNames(Array.from({ length: 5000 }, (_, index) => String(index)).join("\n"))).toHaveLength(300);
});

test("each preset is a button that asks for it by name, and Stop is the last", () => {
  const buttons = ptzButtons(ptzParts(GATE), ["Gate", "Yard"]);
  expect(buttons.map(({ label, args }) => [label, args])).toEqual([
    ["Gate", { place: "Gate" }],
    ["Yard", { place: "Yard" }],
    ["home", {}],
    ["stop", {}],
  ]);
  expect(buttons.at(-1)?.kind).toBe("danger");
});

test("a camera without presets has buttons for what it has", () => {
  expect(ptzButtons(ptzParts({ ...GATE, commands: [command("stop", "camera.abort")] }), ["Gate"])).toHaveLength(1);
});
