/** Devices as the hub describes them, with what a test does not care for left out. */

import type { ArgumentShape, CommandShape, DeviceShape, SignalShape } from "../../../src/generated/api.js";

export function signal(id: string, more: Partial<SignalShape> = {}): SignalShape {
  return {
    id, address: `it/${id}`, name: id, type: "number", role: "none", unit: "", decimals: 1, minimum: null, maximum: null, shown: null, states: [], meanings: [],
    frame: "local", max_age: 5, primary: true, public: false, ros: "", channels: [`it/${id}`], ...more,
  };
}

export function state(id: string, states: readonly string[], more: Partial<SignalShape> = {}): SignalShape {
  return signal(id, { type: "state", states, ...more });
}

export function argument(id: string, more: Partial<ArgumentShape> = {}): ArgumentShape {
  return { id, name: id, type: "number", unit: "", minimum: null, maximum: null, max_length: 200, default: null, ...more };
}

export function command(id: string, args: readonly ArgumentShape[] = [], more: Partial<CommandShape> = {}): CommandShape {
  return { id, name: id, role: "none", description: "", confirm: false, timeout: 10, cancellable: false, needs: null, ros: "", arguments: args, ...more };
}

export function device(
  kind: DeviceShape["kind"], signals: readonly SignalShape[], commands: readonly CommandShape[] = [], more: Partial<DeviceShape> = {},
): DeviceShape {
  return {
    id: "it", name: "Anything", kind, signals, streams: [], commands, drive: null, public: false, link_loss: "", pointing: null, slew: null, unguarded: false,
    rights: ["view", "use"], ...more,
  };
}
