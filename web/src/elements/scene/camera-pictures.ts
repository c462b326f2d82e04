/** The live pictures of described cameras that a scene shows, over their media sockets. */

import { msg } from "@lit/localize";
import type { PictureListener, StreamPictures } from "../../scene/stream-pictures.js";
import { PageRest } from "../../topics/page-rest.js";
import { mediaPath } from "../../wire/media-socket.js";
import { JpegStream } from "../camera/jpeg-stream.js";

interface OpenStream {
  readonly stream: string;
  pictures: JpegStream | null;
}

export class CameraPictures implements StreamPictures {
  private readonly streams = new Map<string, OpenStream>();
  private readonly rest = new PageRest({
    onRest: () => {
      for (const [key, open] of this.streams) {
        this.disconnect(open);
        this.listener.onPicture(key, null);
      }
    },
    onSeen: () => {
      for (const [key, { pictures }] of this.streams) if (pictures === null) this.connect(key);
    },
  });

  constructor(
    private readonly site: string,
    private readonly listener: Pick<PictureListener, "onPicture" | "onTrouble">,
    private readonly openSocket?: (url: string) => WebSocket,
  ) {
    this.rest.watch();
  }

  followStreams(wanted: ReadonlyMap<string, string>): void {
    for (const [key, { stream }] of this.streams) if (wanted.get(key) !== stream) this.end(key);
    for (const [key, stream] of wanted) {
      if (this.streams.has(key)) continue;
      this.streams.set(key, { stream, pictures: null });
      if (!document.hidden) this.connect(key);
    }
  }

  close(): void {
    this.rest.close();
    for (const key of [...this.streams.keys()]) this.end(key);
  }

  private connect(key: string): void {
    const open = this.streams.get(key);
    if (open === undefined) return;
    open.pictures = new JpegStream(
      mediaPath(this.site, open.stream, ["jpeg"]),
      {
        onPicture: (image, timeUs) => {
          this.listener.onTrouble(key, "");
          this.listener.onPicture(key, { image, timeUs, heardMs: performance.now(), rectified: false });
        },
        onSpoilt: () => {
          this.listener.onTrouble(key, msg("A picture came that cannot be decoded."));
        },
        onTrouble: (why) => {
          this.listener.onTrouble(key, why);
        },
        onLost: (why) => {
          this.listener.onPicture(key, null);
          this.listener.onTrouble(key, why);
        },
      },
      this.openSocket,
    );
  }

  private disconnect(open: OpenStream): void {
    open.pictures?.close();
    open.pictures = null;
  }

  private end(key: string): void {
    const open = this.streams.get(key);
    if (open === undefined) return;
    this.disconnect(open);
    this.streams.delete(key);
  }
}
