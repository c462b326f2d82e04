import { describe, expect, it } from "vitest";
import type { CommandShape, DeviceShape } from "../../../src/generated/api.js";
import { groupCommands, isLongList } from "../../../src/tiles/command/command-groups.js";

function command(id: string, role = "none", more: Partial<CommandShape> = {}): CommandShape {
  return { id, name: id, role, description: "", confirm: false, timeout: 10, cancellable: false, arguments: [], needs: null, ros: null, ...more } as CommandShape;
}

function device(id: string, commands: readonly CommandShape[], rights: readonly string[] = ["view", "use"]): DeviceShape {
  return { id, name: id, commands, rights } as unknown as DeviceShape;
}

const FOCUSER = device("focuser", [
  command("focus", "focuser.goto"),
  command("halt", "focuser.stop"),
  ...["connect", "disconnect", "mode", "speed", "seeing"].map((id) => command(id)),
]);
const BASE = device("base", ["beep", "dock", "undock", "home"].map((id) => command(id)));
const DOME = device("dome", [command("open", "dome.open"), command("close", "dome.close"), command("light")]);

function ids(commands: readonly CommandShape[]): string {
  return commands.map(({ id }) => id).join(" ");
}

describe("commands of many devices", () => {
  it("are what stops, what has a role, and behind both the rest", () => {
    const [group] = groupCommands([FOCUSER]);
    expect([ids(group?.urgent ?? []), ids(group?.first ?? []), ids(group?.more ?? [])]).toStrictEqual(["halt", "focus", "connect disconnect mode speed seeing"]);
  });

  it("have nothing behind another section where there are few, or none has a role", () => {
    expect(groupCommands([DOME, BASE]).map(({ urgent, first, more }) => [ids(urgent), ids(first), ids(more)])).toStrictEqual([
      ["close", "open light", ""],
      ["", "beep dock undock home", ""],
    ]);
  });

  it("stop nothing at a touch for who may only look", () => {
    const [group] = groupCommands([device("dome", DOME.commands, ["view"])]);
    expect([ids(group?.urgent ?? []), ids(group?.first ?? [])]).toStrictEqual(["", "open close light"]);
  });

  it("are found by all of the words, wherever they stand, and are then in sight", () => {
    expect(groupCommands([FOCUSER, BASE], "Seeing FOCUSER").map((group) => [group.device.id, ids(group.first), ids(group.more)])).toStrictEqual([["focuser", "seeing", ""]]);
    expect(groupCommands([FOCUSER, BASE], "nothing")).toStrictEqual([]);
    expect(groupCommands([device("weather", [])])).toStrictEqual([]);
  });

  it("are a long list from thirteen on", () => {
    expect([isLongList([FOCUSER, BASE]), isLongList([FOCUSER, BASE, DOME])]).toStrictEqual([false, true]);
  });
});
