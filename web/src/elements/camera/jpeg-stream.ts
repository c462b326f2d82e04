/** The live pictures of a described stream as JPEG: its media socket, and each picture decoded. */

import { MediaSocket, socketUrl } from "../../wire/media-socket.js";
import { JpegPlayer } from "./jpeg-player.js";

export interface JpegListener {
  /** Whoever takes the picture closes it. */
  readonly onPicture: (picture: ImageBitmap, timeUs: number) => void;
  /** A picture came that cannot be decoded. */
  readonly onSpoilt: () => void;
  readonly onTrouble: (why: string) => void;
  /** What was drawn is old now: an old picture is never shown as a new one. */
  readonly onLost: (why: string) => void;
}

/** The bytes are a view on one frame of a socket, which is that picture's alone. */
export function decodePicture(data: Uint8Array, type = ""): Promise<ImageBitmap> {
  return createImageBitmap(new Blob([data as Uint8Array<ArrayBuffer>], { type }));
}

export class JpegStream {
  private readonly player: JpegPlayer;
  private readonly socket: MediaSocket;

  constructor(path: string, listener: JpegListener, openSocket?: (url: string) => WebSocket) {
    this.player = new JpegPlayer({
      decode: ({ data }) => decodePicture(data),
      draw: (picture, { time_us: timeUs }) => {
        listener.onPicture(picture, timeUs);
      },
      failed: listener.onSpoilt,
    });
    this.socket = new MediaSocket(
      { url: socketUrl(path, location), ...(openSocket === undefined ? {} : { openSocket }) },
      {
        onShot: (shot, shown) => {
          this.player.receivePicture(shot, shown);
        },
        onTrouble: listener.onTrouble,
        onState: (state, why) => {
          if (state !== "open") listener.onLost(why);
        },
      },
    );
  }

  setLowRate(low: boolean): void {
    this.socket.setLowRate(low);
  }

  close(): void {
    this.socket.close();
    this.player.close();
  }
}
