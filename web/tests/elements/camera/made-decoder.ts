/** A decoder of pictures that are bytes: each chunk's first byte is the picture. */

/** Pictures that are not closed. */
export const openFrames = new Set<number>();

export class DecoderOfBytes {
  static made: DecoderOfBytes[] = [];
  state = "unconfigured";
  broken = false;
  private readonly waiting: number[] = [];

  constructor(private readonly init: VideoDecoderInit) {
    DecoderOfBytes.made.push(this);
  }

  configure(): void {
    this.state = "configured";
  }

  decode(chunk: { readonly data: Uint8Array }): void {
    this.waiting.push(chunk.data[0] ?? -1);
  }

  flush(): Promise<void> {
    for (const picture of this.waiting.splice(0)) {
      const frame = { picture, close: () => openFrames.delete(picture) };
      openFrames.add(picture);
      this.init.output(frame as unknown as VideoFrame);
    }
    return Promise.resolve();
  }

  close(): void {
    this.state = "closed";
  }
}

export class MadeChunk {
  readonly data: Uint8Array;

  constructor({ data }: { data: Uint8Array }) {
    this.data = data;
  }
}

/** Lets all that waits for nothing but its turn run. */
export async function settle(): Promise<void> {
  for (let i = 0; i < 20; i += 1) await Promise.resolve();
}
