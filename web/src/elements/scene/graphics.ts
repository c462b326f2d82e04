/** What a browser draws with. */

/** Names of renderers that are programs and no hardware: of Chromium, Mesa and Windows. */
const SOFTWARE = /swiftshader|llvmpipe|softpipe|software|basic render/i;

export function isSoftware(renderer: string): boolean {
  return SOFTWARE.test(renderer);
}

/** The name of what draws in space here; empty where it is not said. */
export function rendererName(canvas: Pick<HTMLCanvasElement, "getContext"> = document.createElement("canvas")): string {
  const pen = canvas.getContext("webgl2");
  const told = pen?.getExtension("WEBGL_debug_renderer_info");
  const name: unknown = pen && told ? pen.getParameter(told.UNMASKED_RENDERER_WEBGL) : "";
  // A browser has only so many of them.
  pen?.getExtension("WEBGL_lose_context")?.loseContext();
  return typeof name === "string" ? name : "";
}
