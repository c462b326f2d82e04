/** The live pictures of cameras that a scene shows: of described streams over their media sockets, decoded one at a time. */

import { msg } from "@lit/localize";
import type { PackedPicture, PlainPicture } from "../../scene/picture-messages.js";
import type { ScenePicture } from "../../scene/scene-model.js";
import { PageRest } from "../../topics/page-rest.js";
import { mediaPath } from "../../wire/media-socket.js";
import { decodePicture, JpegStream } from "../camera/jpeg-stream.js";

export interface PictureListener {
  /** `key` is what the picture was asked for by; null: what was shown is not true any more. */
  readonly onPicture: (key: string, picture: ScenePicture | null) => void;
  /** Why no picture comes; empty when nothing is wrong. */
  readonly onTrouble: (key: string, why: string) => void;
}

interface OpenStream {
  readonly stream: string;
  pictures: JpegStream | null;
}

export class CameraPictures {
  private readonly streams = new Map<string, OpenStream>();
  /** Keys whose picture is being decoded; what comes meanwhile is left out. */
  private readonly decoding = new Set<string>();
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
  private closed = false;

  constructor(
    private readonly site: string,
    private readonly listener: PictureListener,
    private readonly openSocket?: (url: string) => WebSocket,
  ) {
    this.rest.watch();
  }

  /** Shows the pictures of these streams and no others. */
  followStreams(wanted: ReadonlyMap<string, string>): void {
    for (const [key, { stream }] of this.streams) if (wanted.get(key) !== stream) this.end(key);
    for (const [key, stream] of wanted) {
      if (this.streams.has(key)) continue;
      this.streams.set(key, { stream, pictures: null });
      if (!document.hidden) this.connect(key);
    }
  }

  /** Shows a picture that came as a message. */
  async showMessage(key: string, picture: PackedPicture | PlainPicture, heardMs: number, rectified: boolean): Promise<void> {
    if (this.decoding.has(key)) return;
    this.decoding.add(key);
    try {
      const image =
        picture.form === "packed"
          ? await decodePicture(picture.data, picture.mime)
          : await createImageBitmap(new ImageData(picture.pixels, picture.width, picture.height));
      if (this.closed) image.close();
      else this.listener.onPicture(key, { image, timeUs: picture.timeUs, heardMs, rectified });
    } catch {
      this.listener.onTrouble(key, msg("A picture came that cannot be decoded."));
    } finally {
      this.decoding.delete(key);
    }
  }

  close(): void {
    this.closed = true;
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
