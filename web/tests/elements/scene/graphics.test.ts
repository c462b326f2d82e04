import { describe, expect, it } from "vitest";
import { isSoftware, rendererName } from "../../../src/elements/scene/graphics.js";

describe("what draws in space", () => {
  it("is told from hardware by its name", () => {
    expect(isSoftware("ANGLE (Google, Vulkan 1.3.0 (SwiftShader Device (Subzero) (0x0000C0DE)), SwiftShader driver)")).toBe(true);
    expect(isSoftware("Mesa/X.org, llvmpipe (LLVM 15.0.6, 256 bits)")).toBe(true);
    expect(isSoftware("ANGLE (Intel, Mesa Intel(R) UHD Graphics 620 (KBL GT2), OpenGL 4.6)")).toBe(false);
    expect(isSoftware("")).toBe(false);
  });

  it("has no name where the browser has no WebGL or does not say it", () => {
    expect(rendererName({ getContext: () => null })).toBe("");
    const silent = { getExtension: () => null };
    expect(rendererName({ getContext: (() => silent) as unknown as HTMLCanvasElement["getContext"] })).toBe("");
  });
});
