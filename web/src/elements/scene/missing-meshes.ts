/** Meshes of one robot that cannot be had: said once, in one sentence, however many links have them. */

import { msg, str } from "@lit/localize";

export class MissingMeshes {
  private readonly sentences = new Set<string>();

  /** @param report told anew with each that is missing */
  constructor(private readonly report: (why: string) => void) {}

  readonly add = (sentence: string): void => {
    if (this.sentences.has(sentence)) return;
    this.sentences.add(sentence);
    const [first = ""] = this.sentences;
    const count = this.sentences.size;
    this.report(count === 1 ? first : msg(str`${String(count)} meshes of the robot are missing. The first: ${first}`));
  };
}
