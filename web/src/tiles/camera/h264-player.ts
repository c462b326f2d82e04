/** A film (H.264) from the socket to the canvas by WebCodecs; every picture is paid for once. */

import type { CameraPicture } from "../../generated/wire.js";

export interface H264Options {
  readonly draw: (frame: VideoFrame, shot: CameraPicture) => void;
  /** The film cannot be gone on with; a fresh one is needed. */
  readonly broken: () => void;
}

interface WaitingFrame {
  readonly shot: CameraPicture;
  readonly shown: () => void;
}

/** What gateways send at the least: the level is raised by a picture's own word. */
export const PLAIN_CODEC = "avc1.42C01E";

/** Asks the browser once. Without https there is no `VideoDecoder` at all. */
export async function supportsH264(scope: { VideoDecoder?: typeof VideoDecoder } = globalThis): Promise<boolean> {
  const decoder = scope.VideoDecoder;
  if (decoder === undefined) return false;
  try {
    return (await decoder.isConfigSupported({ codec: PLAIN_CODEC, optimizeForLatency: true })).supported === true;
  } catch {
    return false;
  }
}

/** Decodes in order, draws what comes out, and says so. */
export class H264Player {
  private decoder: VideoDecoder | null = null;
  private codec = "";
  private readonly waiting = new Map<number, WaitingFrame>();
  private closed = false;

  constructor(private readonly screening: H264Options) {}

  receivePicture(shot: CameraPicture, shown: () => void): void {
    if (this.closed) return;
    if (shot.key) this.configureDecoder(shot.codec);
    if (this.decoder === null) {
      // Nothing to go on from; the hub begins each film with a key picture, so this is rare.
      shown();
      return;
    }
    this.waiting.set(shot.seq, { shot, shown });
    try {
      this.decoder.decode(
        new EncodedVideoChunk({ type: shot.key ? "key" : "delta", timestamp: shot.seq, data: shot.data }),
      );
    } catch {
      this.onDecoderError();
    }
  }

  close(): void {
    this.closed = true;
    this.closeDecoder();
  }

  private configureDecoder(codec: string): void {
    if (this.decoder !== null && (codec === "" || codec === this.codec)) return;
    this.closeDecoder();
    this.codec = codec || PLAIN_CODEC;
    const decoder: VideoDecoder = new VideoDecoder({
      output: (frame) => {
        if (this.decoder === decoder) this.drawFrame(frame);
        else frame.close();
      },
      error: () => {
        if (this.decoder === decoder) this.onDecoderError();
      },
    });
    decoder.configure({ codec: this.codec, optimizeForLatency: true });
    this.decoder = decoder;
  }

  private drawFrame(frame: VideoFrame): void {
    const waiting = this.waiting.get(frame.timestamp);
    if (waiting === undefined) {
      frame.close();
      return;
    }
    this.waiting.delete(frame.timestamp);
    this.screening.draw(frame, waiting.shot);
    waiting.shown();
  }

  private onDecoderError(): void {
    this.closeDecoder();
    this.screening.broken();
  }

  private closeDecoder(): void {
    const { decoder } = this;
    this.decoder = null;
    if (decoder !== null && decoder.state !== "closed") decoder.close();
    // Paid also when it was not drawn: the hub must not wait for it.
    for (const { shown } of this.waiting.values()) shown();
    this.waiting.clear();
  }
}
