import { readFileSync } from "node:fs";
import { describe, expect, it } from "vitest";
import { MessageError, MessageReader } from "../../src/scene/cdr.js";
import { choosePicture, readPackedPicture, readPlainPicture } from "../../src/scene/picture-messages.js";

const RECORDED = JSON.parse(readFileSync(new URL("recorded.json", import.meta.url), "utf8")) as Record<string, string>;
const TYPES = { info: "sensor_msgs/msg/CameraInfo", plain: "sensor_msgs/msg/Image", packed: "sensor_msgs/msg/CompressedImage" } as const;

function readerOf(name: string): MessageReader {
  return new MessageReader(Uint8Array.from(atob(RECORDED[name] ?? ""), (letter) => letter.charCodeAt(0)), "cdr");
}

const listed = (topic: string, kind: keyof typeof TYPES, more: { problem?: string; camera?: string } = {}) => ({ topic, type: TYPES[kind], problem: "", ...more });

describe("the pictures of a calibration", () => {
  const front = listed("/front/camera_info", "info");

  it("are those beside it, packed ones before plain ones", () => {
    const plain = listed("/front/image_raw", "plain");
    const packed = listed("/front/image_raw/compressed", "packed");
    expect(choosePicture(front, [front, plain])).toEqual({ from: "topic", topic: "/front/image_raw", packed: false, rectified: false });
    expect(choosePicture(front, [front, plain, packed])).toEqual({ from: "topic", topic: "/front/image_raw/compressed", packed: true, rectified: false });
    expect(choosePicture(front, [front, listed("/front/image_rect", "plain")])).toMatchObject({ rectified: true });
    expect(choosePicture(listed("/camera_info", "info"), [listed("/images/compressed", "packed")])).toMatchObject({ topic: "/images/compressed" });
  });

  it("are a described camera's where there is one: that line is the cheapest, and blurs what it must", () => {
    expect(choosePicture(listed("/front/camera_info", "info", { camera: "base/front" }), [listed("/front/image_raw/compressed", "packed")])).toEqual({
      from: "stream", stream: "base/front", beside: { from: "topic", topic: "/front/image_raw/compressed", packed: true, rectified: false },
    });
    expect(choosePicture(listed("/front/camera_info", "info", { camera: "base/front" }), [])).toMatchObject({ beside: null });
  });

  it("are not another camera's, nor what cannot be had", () => {
    const others = [listed("/rear/image_raw", "plain"), listed("/front/sub/image/compressed", "packed"), listed("/front/image_raw/compressedDepth", "packed")];
    expect(choosePicture(front, [...others, listed("/front/image_raw", "plain", { problem: "its type is not known" })])).toBeNull();
  });
});

describe("a picture's message", () => {
  it("is read pixel by pixel, whatever order its colours have and whatever lies behind its rows", () => {
    const { width, height, pixels, frame } = readPlainPicture(readerOf("image"));
    expect([frame, width, height]).toEqual(["camera_optical_frame", 2, 2]);
    expect([...pixels]).toEqual([0, 0, 255, 255, 0, 255, 0, 255, 255, 0, 0, 255, 30, 20, 10, 255]);
  });

  it("of depths is shown from the nearest to the farthest", () => {
    const { pixels } = readPlainPicture(readerOf("depth"));
    expect([...pixels].filter((_, at) => at % 4 === 0)).toEqual([0, 255, 128]);
  });

  it("that a browser decodes says by its own bytes what it is", () => {
    expect(readPackedPicture(readerOf("compressed"))).toMatchObject({ mime: "image/jpeg", frame: "camera_optical_frame" });
  });

  it("that is none is refused", () => {
    expect(() => readPlainPicture(readerOf("compressed"))).toThrow(MessageError);
    expect(() => readPackedPicture(readerOf("image"))).toThrow(MessageError);
  });
});
