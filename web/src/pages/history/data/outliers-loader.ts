/** The quartiles of the shown window, of every sample in it, where the chart holds only some of them. */

import type { OutlierList, OutlierShape } from "../../../generated/api.js";
import type { TimeSpan } from "../../../series/time-window.js";
import { LatestRequest, type RequestStatus } from "./latest-request.js";
import { windowDistance } from "./statistics-loader.js";

export interface OutliersSource {
  outliers(site: string, channels: readonly string[], span: TimeSpan, k: number, signal?: AbortSignal): Promise<OutlierList>;
}

interface OutliersQuestion {
  readonly site: string;
  readonly channels: readonly string[];
  readonly span: TimeSpan;
  readonly k: number;
}

/** A window that follows is looked at again once it has moved by this part of itself. */
const STEP = 0.05;
/** What was found in a window is not said of one that is this much another. */
const NEAR = 0.1;

export class OutliersLoader {
  private found: ReadonlyMap<string, OutlierShape> = NONE;
  private of: OutliersQuestion | null = null;
  private asked: OutliersQuestion | null = null;
  private readonly asker: LatestRequest<OutliersQuestion, OutlierList>;

  constructor(finding: OutliersSource, changed: () => void) {
    this.asker = new LatestRequest<OutliersQuestion, OutlierList>({
      fetch: ({ site, channels, span, k }, signal) => finding.outliers(site, channels, span, k, signal),
      // It may take seconds: what nobody wants any more is given up.
      isStillUseful: () => false,
      onAnswer: (list, question) => {
        this.found = new Map(list.outliers.map((outlier) => [outlier.address, outlier]));
        this.of = question;
      },
      onChange: changed,
    });
  }

  get state(): RequestStatus {
    return this.asker.state;
  }

  /** @param following the window goes with the time: it is not looked at again with each step */
  loadOutliers(site: string, channels: readonly string[], span: TimeSpan, k: number, following: boolean): void {
    if (k === 0 || channels.length === 0) {
      if (this.asked !== null) this.close();
      return;
    }
    const before = this.asked;
    const same = before !== null && before.site === site && before.k === k && before.channels.join("\n") === channels.join("\n");
    if (same && following && windowDistance(before.span, span) < STEP) return;
    this.asked = { site, channels, span: { fromUs: Math.round(span.fromUs), toUs: Math.round(span.toUs) }, k };
    this.asker.request(this.asked);
  }

  /** What was found in a window, or in one that is hardly another. */
  foundIn(site: string, span: TimeSpan, k: number): ReadonlyMap<string, OutlierShape> {
    const known = this.of !== null && this.of.site === site && this.of.k === k && windowDistance(this.of.span, span) < NEAR;
    return known ? this.found : NONE;
  }

  close(): void {
    this.asker.cancelRequest();
    this.of = null;
    this.asked = null;
  }
}

const NONE: ReadonlyMap<string, OutlierShape> = new Map();
