/** Looks a target's name up among the hub's catalogue, stars and the Moon, for the form. */

import { msg, str } from "@lit/localize";
import type { ReactiveController, ReactiveControllerHost } from "lit";
import { ActionController } from "../../../controllers/action.js";
import type { Advice } from "../../../format/error-advice.js";
import type { SkyObject } from "../../../generated/api.js";
import { catalogueTarget, ownTargets, type SkyTarget } from "../../../tiles/observatory/sky-target.js";
import type { RequestDraft } from "./draft.js";
import { coordinateTexts } from "./fill-draft.js";

export class TargetFinder implements ReactiveController {
  /** What was found by the last name. */
  found: readonly SkyTarget[] = [];
  /** The same in words. */
  text = "";
  private readonly action: ActionController;

  /**
   * @param nameOf what is written now
   * @param search asks the hub's catalogue
   * @param write changes the request that is shown
   */
  constructor(
    private readonly host: ReactiveControllerHost,
    private readonly nameOf: () => string,
    private readonly search: (name: string) => Promise<readonly SkyObject[]>,
    private readonly write: (change: Partial<RequestDraft>) => void,
  ) {
    this.action = new ActionController(host);
    host.addController(this);
  }

  get busy(): boolean {
    return this.action.busy;
  }

  get problem(): Advice | null {
    return this.action.problem;
  }

  hostConnected(): void {
    this.forget();
  }

  /** Another request is shown. */
  forget(): void {
    this.found = [];
    this.text = "";
    this.host.requestUpdate();
  }

  choose(target: SkyTarget): void {
    if (target.j2000 === null) {
      this.write({ way: "body", body: "moon", target: target.name });
      return;
    }
    this.text = `${target.name}: ${target.about}.`;
    this.write({ target: target.name, ...coordinateTexts(target.j2000.ra * 15, target.j2000.dec), motionRa: "", motionDec: "", epoch: "" });
  }

  /** For the button of one that was found. */
  chooser(target: SkyTarget): () => void {
    return () => {
      this.choose(target);
    };
  }

  readonly find = (): void => {
    const name = this.nameOf().trim();
    if (name === "") {
      this.text = msg("Write a name first.");
      this.host.requestUpdate();
      return;
    }
    void this.action.run(msg("search the catalogue"), async () => {
      this.found = [...ownTargets(name), ...(await this.search(name)).map(catalogueTarget)];
      const [first] = this.found;
      if (first === undefined) this.text = msg(str`Nothing goes by the name ${name}: write its coordinates.`);
      else this.choose(first);
    });
  };

  /** Enter in the name looks it up, instead of sending the form. */
  readonly onKey = (event: KeyboardEvent): void => {
    if (event.key !== "Enter") return;
    event.preventDefault();
    event.stopPropagation();
    this.find();
  };
}
