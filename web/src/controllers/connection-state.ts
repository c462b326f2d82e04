/** Ties the state of the connection to an element. */

import { ContextConsumer } from "@lit/context";
import type { ReactiveController, ReactiveControllerHost } from "lit";
import { connectionContext } from "../state/contexts.js";
import type { Connection, LinkState } from "../wire/connection.js";

/**
 * Gives the connection and its state, and draws the element again when the state changes.
 * `attach` is called each time the element and a connection come together; what it returns is
 * called when they part. It is the place for `connection.on(…)`.
 */
export class ConnectionStateController implements ReactiveController {
  private found: Connection | undefined;
  private stops: (() => void)[] = [];

  constructor(
    private readonly host: ReactiveControllerHost & HTMLElement,
    private readonly attach: (connection: Connection) => readonly (() => void)[] = () => [],
  ) {
    host.addController(this);
    new ContextConsumer(host, {
      context: connectionContext,
      callback: (connection) => {
        this.found = connection;
        this.subscribeConnection();
      },
    });
  }

  get connection(): Connection | undefined {
    return this.found;
  }

  get state(): LinkState {
    return this.found?.state ?? "idle";
  }

  hostConnected(): void {
    this.subscribeConnection();
  }

  hostDisconnected(): void {
    for (const stop of this.stops) stop();
    this.stops = [];
  }

  private subscribeConnection(): void {
    const connection = this.found;
    if (connection === undefined || this.stops.length > 0 || !this.host.isConnected) return;
    this.stops = [
      connection.onState(() => {
        this.host.requestUpdate();
      }),
      ...this.attach(connection),
    ];
    this.host.requestUpdate();
  }
}
