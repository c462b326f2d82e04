/** Ties the anomaly detectors of a site to an element: asked for once, and then told. */

import type { ReactiveController, ReactiveControllerHost } from "lit";
import { DetectorBook } from "../state/anomaly-detectors.js";
import type { AnomalyList } from "../wire/api-types.js";
import { LinkController } from "./connection-state.js";
import { LoadController } from "./load.js";

/** What this needs of the hub's HTTP interface. */
export interface Watchers {
  anomalies(site: string): Promise<AnomalyList>;
}

export class DetectorsController implements ReactiveController {
  book = new DetectorBook();
  private readonly load: LoadController<AnomalyList>;
  private site = "";
  private taken: AnomalyList | undefined;

  constructor(host: ReactiveControllerHost & HTMLElement) {
    host.addController(this);
    this.load = new LoadController(host);
    new LinkController(host, (connection) => [
      connection.on("anomaly", (news) => {
        if (news.site === this.site && this.book.hear(news)) host.requestUpdate();
      }),
      connection.onState((state) => {
        // What was told meanwhile was not heard.
        if (state === "open") this.again();
      }),
    ]);
  }

  get state(): "idle" | "loading" | "ready" | "failed" {
    return this.load.result.state;
  }

  /** There is a list, though a newer one may be on its way. */
  get known(): boolean {
    return this.load.value !== undefined;
  }

  get error(): unknown {
    return this.load.result.state === "failed" ? this.load.result.error : null;
  }

  /** Call it from `willUpdate`. @param edition names the site's description: another one has other detectors */
  ask(api: Watchers, site: string, edition: string): void {
    if (site !== this.site) {
      this.site = site;
      this.book = new DetectorBook();
      this.taken = undefined;
    }
    this.load.ask(`${site} ${edition}`, () => {
      this.book.asking();
      return api.anomalies(site);
    });
    const { result } = this.load;
    if (result.state !== "ready" || result.value === this.taken) return;
    this.taken = result.value;
    this.book.answered(result.value);
  }

  again(): void {
    this.load.again();
  }

  hostConnected(): void {
    this.taken = undefined;
  }
}
