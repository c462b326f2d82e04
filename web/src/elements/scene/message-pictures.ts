/** Pictures of cameras that come as messages of raw topics, decoded one at a time. */

import { msg } from "@lit/localize";
import type { PackedPicture, PlainPicture } from "../../scene/picture-messages.js";
import type { PictureListener } from "../../scene/stream-pictures.js";
import { decodePicture } from "../camera/jpeg-stream.js";

export class MessagePictures {
  /** Keys whose picture is being decoded; what comes meanwhile is left out. */
  private readonly decoding = new Set<string>();
  private closed = false;

  constructor(private readonly listener: Pick<PictureListener, "onPicture" | "onTrouble">) {}

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
  }
}
