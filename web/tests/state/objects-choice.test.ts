import { expect, test } from "vitest";
import { AS_DESCRIBED, keepObjects, keepShownModels, readObjects, readShownModels } from "../../src/state/objects-choice.js";

function notes(): Map<string, string> & Pick<Storage, "getItem" | "setItem" | "removeItem"> {
  const kept = new Map<string, string>();
  return Object.assign(kept, {
    getItem: (key: string) => kept.get(key) ?? null,
    setItem: (key: string, value: string) => void kept.set(key, value),
    removeItem: (key: string) => void kept.delete(key),
  });
}
const CHOICE = { on: false, classes: ["dog"], confidence: 0.4 };

test("each person has a choice of their own for each camera", () => {
  const kept = notes();
  keepObjects(kept, "ada", "agv", "camera/front", CHOICE);
  expect(readObjects(kept, "ada", "agv", "camera/front")).toEqual(CHOICE);
  for (const [person, site, stream] of [["bob", "agv", "camera/front"], ["ada", "dome", "camera/front"], ["ada", "agv", "camera/rear"]] as const) {
    expect(readObjects(kept, person, site, stream)).toEqual(AS_DESCRIBED);
  }
});

test("as described is nothing to keep", () => {
  const kept = notes();
  keepObjects(kept, "ada", "agv", "c", CHOICE);
  keepObjects(kept, "ada", "agv", "c", AS_DESCRIBED);
  expect(kept.size).toBe(0);
});

test("what somebody else wrote there is taken for what it can be", () => {
  for (const [text, choice] of [
    ["{", AS_DESCRIBED], ["null", AS_DESCRIBED], ["7", AS_DESCRIBED],
    ['{"on":false,"classes":["dog",3],"confidence":9}', { on: false, classes: ["dog"], confidence: null }],
    ['{"classes":"dog","confidence":0.1}', AS_DESCRIBED],
  ] as const) {
    const kept = notes();
    keepObjects(kept, "a", "b", "c", CHOICE);
    kept.set([...kept.keys()][0] ?? "", text);
    expect(readObjects(kept, "a", "b", "c")).toEqual(choice);
  }
});

test("a browser that keeps nothing, or is full, is no hindrance", () => {
  expect(readObjects(null, "a", "b", "c")).toEqual(AS_DESCRIBED);
  const full = { getItem: () => null, removeItem: () => undefined, setItem: () => { throw new Error("full"); } };
  keepObjects(full, "a", "b", "c", CHOICE);
  expect(readObjects(full, "a", "b", "c")).toEqual(AS_DESCRIBED);
});

test("which models are drawn is kept for each person and camera, beside the objects", () => {
  const kept = notes();
  keepObjects(kept, "ada", "agv", "c", CHOICE);
  keepShownModels(kept, "ada", "agv", "c", { ground: false, far: true });
  expect(readShownModels(kept, "ada", "agv", "c")).toEqual({ ground: false, far: true });
  expect(readShownModels(kept, "bob", "agv", "c")).toEqual({});
  expect(readObjects(kept, "ada", "agv", "c")).toEqual(CHOICE);
  expect(readShownModels(null, "ada", "agv", "c")).toEqual({});
  for (const key of kept.keys()) kept.set(key, '{"ground": "no", "far": true}');
  expect(readShownModels(kept, "ada", "agv", "c")).toEqual({ far: true });
  for (const key of kept.keys()) kept.set(key, "[");
  expect(readShownModels(kept, "ada", "agv", "c")).toEqual({});
});
