import { expect, test } from "vitest";
import { HapticCues, playCue, type FeltState } from "../../../src/controllers/drive/haptics.js";

const CALM: FeltState = { stopped: false, locked: false, limited: false };

test("what stands when the page opens is not felt; what comes then is, once", () => {
  const cues = new HapticCues();
  expect(cues.nextCue({ ...CALM, locked: true }, 0)).toBeNull();
  expect(cues.nextCue({ ...CALM, locked: true, limited: true }, 10)).toBe("limit");
  expect(cues.nextCue({ ...CALM, locked: true, limited: true }, 20)).toBeNull();
  expect(cues.nextCue({ stopped: true, locked: true, limited: true }, 30)).toBe("stop");
});

test("STOP goes before an interlock, and that before a limit", () => {
  const cues = new HapticCues();
  cues.nextCue(CALM, 0);
  expect(cues.nextCue({ stopped: true, locked: true, limited: true }, 1)).toBe("stop");
  const others = new HapticCues();
  others.nextCue(CALM, 0);
  expect(others.nextCue({ stopped: false, locked: true, limited: true }, 1)).toBe("interlock");
});

test("a limit that comes and goes does not buzz without end", () => {
  const cues = new HapticCues();
  cues.nextCue(CALM, 0);
  const felt = Array.from({ length: 40 }, (_, i) => cues.nextCue({ ...CALM, limited: i % 2 === 0 }, i * 100));
  expect(felt.filter((cue) => cue === "limit")).toHaveLength(3);
});

test("phone and gamepads shake, each as it can; a browser without either stays still", () => {
  const phone: number[][] = [];
  const pads: number[] = [];
  const actuator = {
    playEffect: (_type: string, { duration }: { duration: number }) => {
      pads.push(duration);
      return Promise.reject(new Error("busy"));
    },
  };
  const device = { vibrate: (rhythm: number[]) => phone.push(rhythm) > 0, getGamepads: () => [null, { vibrationActuator: actuator }, { vibrationActuator: null }] };
  playCue("stop", device);
  playCue("limit", { ...device, userActivation: { hasBeenActive: false } });
  expect(phone).toEqual([[300, 80, 300]]);
  expect(pads).toEqual([680, 60]);
  expect(() => {
    playCue("interlock", {});
  }).not.toThrow();
});
