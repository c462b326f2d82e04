/** What may be asked of the hub about boards. */

import type { BoardDetail, BoardList, BoardReading, BoardSaved, BoardShape, BoardShareAsk, BoardText, BoardVersionList } from "../generated/api.js";
import type { HubApi } from "../wire/hub-api.js";

const boardUrl = (key: string, more = ""): string => `/api/boards/${encodeURIComponent(key)}${more}`;

export class BoardsApi {
  constructor(private readonly hub: Pick<HubApi, "request">) {}

  listBoards(): Promise<BoardList> {
    return this.hub.request("GET", "/api/boards");
  }

  readBoard(key: string): Promise<BoardDetail> {
    return this.hub.request("GET", boardUrl(key));
  }

  readVersion(key: string, number: number): Promise<BoardDetail> {
    return this.hub.request("GET", boardUrl(key, `/versions/${String(number)}`));
  }

  listVersions(key: string): Promise<BoardVersionList> {
    return this.hub.request("GET", boardUrl(key, "/versions"));
  }

  addBoard(board: BoardShape, note = ""): Promise<BoardSaved> {
    return this.hub.request("POST", "/api/boards", { board, note });
  }

  /** @param base the newest version that is known here */
  saveBoard(key: string, board: BoardShape, base: number, note = ""): Promise<BoardSaved> {
    return this.hub.request("PUT", boardUrl(key), { board, base, note });
  }

  restoreVersion(key: string, number: number, base: number): Promise<BoardSaved> {
    return this.hub.request("POST", boardUrl(key, `/versions/${String(number)}/restore`), { base });
  }

  async removeBoard(key: string): Promise<void> {
    await this.hub.request("DELETE", boardUrl(key));
  }

  async shareBoard(key: string, asked: BoardShareAsk): Promise<void> {
    await this.hub.request("PUT", boardUrl(key, "/share"), asked);
  }

  async publishBoard(key: string): Promise<void> {
    await this.hub.request("PUT", boardUrl(key, "/public"), {});
  }

  async writeText(board: BoardShape): Promise<string> {
    return (await this.hub.request<BoardText>("POST", "/api/boards/text", { board })).text;
  }

  readText(text: string): Promise<BoardReading> {
    return this.hub.request("POST", "/api/boards/reading", { text });
  }
}
