/** The live pictures of cameras that a scene shows: of described streams over their media sockets, decoded one at a time. */

import { msg } from "@lit/localize";
import type { PackedPicture, PlainPicture } from "../../scene/picture-messages.js";
import type { ScenePicture } from "../../scene/scene-model.js";
import { JpegPlayer } from "../camera/jpeg-player.js";
import { MediaSocket, mediaPath, socketUrl } from "../../wire/media-socket.js";

/** A page that is hidden for so long (ms) lets the robot rest. */
const HIDDEN_MS = 5000;

export interface PictureListener {
  /** `key` is what the picture was asked for by; null: what was shown is not true any more. */
  readonly onPicture: (key: string, picture: ScenePicture | null) => void;
  /** Why no picture comes; empty when nothing is wrong. */
  readonly onTrouble: (key: string, why: string) => void;
}

interface OpenStream {
  readonly stream: string;
  socket: MediaSocket | null;
  player: JpegPlayer | null;
}

export class CameraPictures {
  private readonly streams = new Map<string, OpenStream>();
  /** Keys whose picture is being decoded; what comes meanwhile is left out. */
  private readonly decoding = new Set<string>();
  private timer: ReturnType<typeof setTimeout> | undefined;
  private closed = false;

  constructor(
    private readonly site: string,
    private readonly listener: PictureListener,
    private readonly openSocket?: (url: string) => WebSocket,
  ) {
    document.addEventListener("visibilitychange", this.onVisibility);
  }

  /** Shows the pictures of these streams and no others. */
  followStreams(wanted: ReadonlyMap<string, string>): void {
    for (const [key, { stream }] of this.streams) if (wanted.get(key) !== stream) this.end(key);
    for (const [key, stream] of wanted) {
      if (this.streams.has(key)) continue;
      this.streams.set(key, { stream, socket: null, player: null });
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
          ? // The bytes are a view on one frame of the socket, which is ours alone.
            await createImageBitmap(new Blob([picture.data as Uint8Array<ArrayBuffer>], { type: picture.mime }))
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
    clearTimeout(this.timer);
    document.removeEventListener("visibilitychange", this.onVisibility);
    for (const key of [...this.streams.keys()]) this.end(key);
  }

  private connect(key: string): void {
    const open = this.streams.get(key);
    if (open === undefined) return;
    const player = new JpegPlayer({
      decode: ({ data }) => createImageBitmap(new Blob([data as Uint8Array<ArrayBuffer>])),
      draw: (image, { time_us: timeUs }) => {
        this.listener.onTrouble(key, "");
        this.listener.onPicture(key, { image, timeUs, heardMs: performance.now(), rectified: false });
      },
      failed: () => {
        this.listener.onTrouble(key, msg("A picture came that cannot be decoded."));
      },
    });
    open.player = player;
    open.socket = new MediaSocket(
      { url: socketUrl(mediaPath(this.site, open.stream, ["jpeg"]), location), ...(this.openSocket === undefined ? {} : { openSocket: this.openSocket }) },
      {
        onShot: (shot, shown) => {
          player.receivePicture(shot, shown);
        },
        onTrouble: (why) => {
          this.listener.onTrouble(key, why);
        },
        onState: (state, why) => {
          if (state === "open") return;
          // What was drawn is old now: an old picture is never shown as a new one.
          this.listener.onPicture(key, null);
          this.listener.onTrouble(key, why);
        },
      },
    );
  }

  private disconnect(open: OpenStream): void {
    open.socket?.close();
    open.player?.close();
    [open.socket, open.player] = [null, null];
  }

  private end(key: string): void {
    const open = this.streams.get(key);
    if (open === undefined) return;
    this.disconnect(open);
    this.streams.delete(key);
  }

  private readonly onVisibility = (): void => {
    clearTimeout(this.timer);
    if (document.hidden) {
      this.timer = setTimeout(() => {
        for (const [key, open] of this.streams) {
          this.disconnect(open);
          this.listener.onPicture(key, null);
        }
      }, HIDDEN_MS);
      return;
    }
    for (const [key, { socket }] of this.streams) if (socket === null) this.connect(key);
  };
}
