import { readFileSync } from "node:fs";
import { afterEach, beforeEach, describe, expect, it, vi } from "vitest";
import { SceneSession, type SceneTopicEntry } from "../../../src/elements/scene/scene-session.js";
import type { TopicBytes } from "../../../src/generated/wire.js";
import type { ScenePicture } from "../../../src/scene/scene-model.js";
import type { PictureListener } from "../../../src/scene/stream-pictures.js";
import type { TopicListener } from "../../../src/topics/topic-socket.js";

const RECORDED = JSON.parse(readFileSync(new URL("../../scene/recorded.json", import.meta.url), "utf8")) as Record<string, string>;
const INFO = "/front/camera_info";
const RAW = "/front/image_raw/compressed";
const calibration: SceneTopicEntry = { topic: INFO, type: "sensor_msgs/msg/CameraInfo", problem: "", camera: "base/front" };
const picture: SceneTopicEntry = { topic: RAW, type: "sensor_msgs/msg/CompressedImage", problem: "" };

function messageOf(name: string): TopicBytes {
  const data = Uint8Array.from(atob(RECORDED[name] ?? ""), (letter) => letter.charCodeAt(0));
  return { t: "topic_bytes", number: 1, seq: 1, time_us: 0, publish_us: 0, age_ms: 0, encoding: "cdr", every: 1, data };
}

/** A scene at a past moment, of which the test says what comes. */
function makeSession(topics: readonly SceneTopicEntry[]) {
  const followed = new Map<string, TopicListener>();
  const closed: string[] = [];
  let heard: PictureListener | null = null;
  let streams: ReadonlyMap<string, string> = new Map();
  const session = new SceneSession("agv", { onChange: () => undefined, onState: () => undefined }, {
    nowMs: () => 60_000,
    open: (_path, listener, { topic }) => {
      followed.set(topic, listener);
      return { close: () => followed.delete(topic) };
    },
    openPictures: (listener) => {
      heard = listener;
      return {
        followStreams: (wanted) => {
          streams = wanted;
        },
        // As films do, which withdraw what they have said.
        close: () => {
          listener.onMissing(INFO, false);
        },
      };
    },
  });
  session.setTopics(topics, []);
  session.show(INFO, true);
  const made = (name: string, timeUs = 59e6): ScenePicture => ({ image: { name, width: 4, height: 4, close: () => closed.push(name) } as unknown as ImageBitmap, timeUs, heardMs: timeUs / 1000, rectified: false });
  const shown = (): unknown => {
    const content = session.model.layers.get(INFO)?.content;
    return content?.shape === "camera" ? ((content.picture?.image as { name?: string } | undefined)?.name ?? null) : undefined;
  };
  const listener = (): PictureListener => {
    if (heard === null) throw new Error("nothing is listened to");
    return heard;
  };
  return { session, followed, closed, made, shown, listener, streams: () => [...streams] };
}

describe("a scene's session", () => {
  beforeEach(() => {
    vi.stubGlobal("document", { hidden: false, addEventListener: () => undefined, removeEventListener: () => undefined });
  });
  afterEach(() => {
    vi.unstubAllGlobals();
  });

  it("has a described camera's pictures from where it is told, and none of the raw topic beside them", () => {
    const { followed, made, shown, listener, streams } = makeSession([calibration, picture]);
    expect(streams()).toEqual([[INFO, "base/front"]]);
    expect([...followed.keys()]).toEqual([INFO]);
    listener().onPicture(INFO, made("film"));
    followed.get(INFO)?.onBytes?.(messageOf("camera_info"));
    expect(shown()).toBe("film");
  });

  it("follows the raw topic where the camera has no film of the moment, until it has one", () => {
    const { session, followed, made, shown, listener, streams } = makeSession([calibration, picture]);
    followed.get(INFO)?.onBytes?.(messageOf("camera_info"));
    listener().onTrouble(INFO, "No film of this moment");
    listener().onMissing(INFO, true);
    expect([...followed.keys()]).toEqual([INFO, RAW]);
    // The film is still asked for as the moment moves, and what is there is said to be so.
    expect([streams(), session.problemOf(INFO)]).toEqual([[[INFO, "base/front"]], ""]);
    listener().onMissing(INFO, false);
    listener().onPicture(INFO, made("film"));
    expect([[...followed.keys()], shown()]).toEqual([[INFO], "film"]);
  });

  it("says why there is no picture where there is nothing beside it", () => {
    const { session, followed, listener } = makeSession([calibration]);
    listener().onTrouble(INFO, "No film of this moment");
    listener().onMissing(INFO, true);
    expect([session.problemOf(INFO), [...followed.keys()]]).toEqual(["No film of this moment", [INFO]]);
  });

  it("keeps a film's picture when messages of another moment come: it has a moment of its own", () => {
    const { session, followed, closed, made, shown, listener } = makeSession([calibration]);
    followed.get(INFO)?.onBytes?.(messageOf("camera_info"));
    listener().onPicture(INFO, made("film"));
    session.reset();
    expect([shown(), closed]).toEqual([undefined, []]);
    followed.get(INFO)?.onBytes?.(messageOf("camera_info"));
    expect(shown()).toBe("film");
    session.forget(INFO);
    followed.get(INFO)?.onBytes?.(messageOf("camera_info"));
    expect(shown()).toBe("film");
  });

  it("lets go of all when it ends, and follows nothing anew", () => {
    const { session, followed, closed, made, listener } = makeSession([calibration, picture]);
    listener().onPicture(INFO, made("film"));
    session.close();
    expect([closed, [...followed.keys()]]).toEqual([["film"], []]);
  });
});
